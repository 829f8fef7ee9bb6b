"""Planar arms among rectangles, twice: as a robot and a scene for the planner, and as exact geometry in the plane."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from planner.base.arrays import Floats
from planner.base.files import write_whole
from planner.cost.scale import CostScale
from planner.problem.options import RobotLike
from planner.robot.poses import pose
from planner.robot.scene import Obstacle, Scene
from planner.robot.shapes import Box

_THICK = 0.2  # m: height of the obstacles, so that the plane of the arm cuts them


@dataclass(frozen=True, eq=False)
class PlanarArm:
    """An arm whose links are capsules in one plane, among rectangles with sides along x and y.

    ``reach`` (n,) m from joint to joint, and to the tool; ``solid`` (n,) m how far each capsule's axis goes; ``radius``
    (n,) m; ``limits`` (n,) rad, the same both ways; ``boxes`` (k, 4): x, y, width, depth (m). Links do not touch each
    other. ``robot`` is what the planner is asked for; None for an arm whose URDF :meth:`robot_in` writes.
    """

    name: str
    reach: Floats
    solid: Floats
    radius: Floats
    limits: Floats
    boxes: Floats
    start: Floats
    goal: Floats
    robot: str | None = None

    @cached_property
    def scene(self) -> Scene:
        """The rectangles as boxes."""
        solids = [Box((width, depth, _THICK)) for _, _, width, depth in self.boxes.tolist()]
        places = [pose([x, y, 0]) for x, y, *_ in self.boxes.tolist()]
        return Scene(
            self.name, tuple(Obstacle(f"box{k}", *each) for k, each in enumerate(zip(solids, places, strict=True)))
        )

    def robot_in(self, folder: Path) -> RobotLike:
        """The robot's name, or the path of its robot.yaml, which is written to ``folder``."""
        if self.robot is not None:
            return self.robot
        write_whole(folder / f"{self.name}.urdf", _urdf(self).encode())
        write_whole(folder / "robot.yaml", _description(self).encode())
        return str(folder / "robot.yaml")

    def clearance(self, q: Floats) -> Floats:
        """(m,) m, exact, from the nearest link to the nearest rectangle at configurations (m, n); contact at 0."""
        heading, base = np.cumsum(q, axis=1), np.zeros((len(q), 2))
        least = np.full(len(q), np.inf)
        for k, far in enumerate(self.reach):
            ahead = np.column_stack([np.cos(heading[:, k]), np.sin(heading[:, k])])
            for box in self.boxes:
                least = np.minimum(least, segment_to_box(base, base + self.solid[k] * ahead, box) - self.radius[k])
            base = base + far * ahead
        return least

    def motion(self, delta: Floats) -> Floats:
        """(m,) m: no point of the arm moves farther when its joints move by ``delta`` (m, n)."""
        return (np.abs(delta) * np.cumsum(self.reach[::-1])[::-1]).sum(axis=1)

    def manipulability(self, q: Floats) -> Floats:
        """(m,) w = sqrt(det J Jᵀ) of the tool's position in the plane at configurations (m, n)."""
        heading = np.cumsum(q, axis=1)
        links = self.reach[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=2)
        arms = np.cumsum(links[:, ::-1], axis=1)[:, ::-1]  # from each joint to the tool
        xx, yy = (arms[..., 0] ** 2).sum(axis=1), (arms[..., 1] ** 2).sum(axis=1)
        xy = (arms[..., 0] * arms[..., 1]).sum(axis=1)
        return np.sqrt(np.maximum(xx * yy - xy * xy, 0.0))

    def rate(self, q: Floats, beta: float, scale: CostScale) -> Floats:
        """(m,) what a path costs per rad at configurations (m, n): (1 - beta) omega + beta."""
        if beta == 1.0:
            return np.ones(len(q))
        w = np.clip(self.manipulability(q), scale.w_low, scale.w_high)
        omega = scale.zeta + (1.0 - scale.zeta) * np.log(scale.w_high / w) / np.log(scale.w_high / scale.w_low)
        return (1.0 - beta) * omega + beta


def segment_to_box(a: Floats, b: Floats, box: Floats) -> Floats:
    """(m,) exact distances in the plane from segments a b, (m, 2) each, to a rectangle (x, y, width, depth)."""
    half = 0.5 * box[2:]
    a, b = a - box[:2], b - box[:2]
    ends = np.minimum(_point_to_box(a, half), _point_to_box(b, half))
    corners = half * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    along = b - a
    share = ((corners - a[:, None]) * along[:, None]).sum(axis=2) / np.maximum((along**2).sum(axis=1), 1e-300)[:, None]
    feet = a[:, None] + np.clip(share, 0.0, 1.0)[..., None] * along[:, None]
    apart = np.minimum(ends, np.linalg.norm(corners - feet, axis=2).min(axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (-half - a) / along, (half - a) / along
        enter, leave = np.minimum(first, second), np.maximum(first, second)
        beside = (along == 0) & (np.abs(a) > half)
        enter, leave = (np.where(along == 0, other, times) for other, times in ((-np.inf, enter), (np.inf, leave)))
    crosses = ~beside.any(axis=1) & (np.maximum(enter.max(axis=1), 0.0) <= np.minimum(leave.min(axis=1), 1.0))
    return np.where(crosses, 0.0, apart)


def _point_to_box(points: Floats, half: Floats) -> Floats:
    return np.linalg.norm(np.maximum(np.abs(points) - half, 0.0), axis=1)


def _urdf(arm: PlanarArm) -> str:
    count, joint_at = len(arm.reach), [0.0, *arm.reach.tolist()]
    parts = ['<link name="base"/>', '<link name="tool"/>']
    for k in range(1, count + 1):
        solid, limit, parent = arm.solid[k - 1], arm.limits[k - 1], "base" if k == 1 else f"link_{k - 1}"
        parts += [
            f'<link name="link_{k}"><collision><origin xyz="{solid / 2} 0 0" rpy="0 1.5707963267948966 0"/><geometry>'
            f'<capsule radius="{arm.radius[k - 1]}" length="{solid}"/></geometry></collision></link>',
            f'<joint name="joint_{k}" type="revolute"><parent link="{parent}"/><child link="link_{k}"/>'
            f'<origin xyz="{joint_at[k - 1]} 0 0"/><axis xyz="0 0 1"/>'
            f'<limit lower="{-limit}" upper="{limit}" velocity="2" effort="10"/></joint>',
        ]
    parts.append(
        f'<joint name="joint_tool" type="fixed"><parent link="link_{count}"/><child link="tool"/>'
        f'<origin xyz="{joint_at[count]} 0 0"/></joint>'
    )
    return "\n".join(['<?xml version="1.0"?>', f'<robot name="{arm.name}" version="1.1">', *parts, "</robot>\n"])


def _description(arm: PlanarArm) -> str:
    count = len(arm.reach)
    pairs = "".join(f"  - [link_{i}, link_{j}]\n" for i in range(1, count + 1) for j in range(i + 1, count + 1))
    home = ", ".join("0.3" for _ in arm.reach)
    return (
        f"description: planar arm with {count} joints, for the study of optima\nurdf: {{file: {arm.name}.urdf}}\n"
        f"tool: tool\nhome: [{home}]\nmanipulability: planar\ndisabled_pairs:\n{pairs}"
    )


BAR = np.array([[0.75, 0.0, 0.1, 0.04]])
TWO_JOINTS = PlanarArm(
    "planar_2r",
    reach=np.array([0.5, 0.4]),
    solid=np.array([0.5, 0.375]),
    radius=np.array([0.03, 0.025]),
    limits=np.array([3.141592653589793, 2.9670597283903604]),
    boxes=BAR,
    start=np.array([-1.0, 0.8]),
    goal=np.array([1.3, -0.8]),
    robot="planar_2r",
)
THREE_JOINTS = PlanarArm(
    "planar_3r",
    reach=np.array([0.4, 0.3, 0.2]),
    solid=np.array([0.4, 0.3, 0.18]),
    radius=np.array([0.025, 0.02, 0.02]),
    limits=np.array([2.9, 2.4, 2.4]),
    boxes=np.array([[0.62, 0.0, 0.1, 0.05], [0.72, 0.35, 0.08, 0.08]]),
    start=np.array([-1.0, 0.6, 0.5]),
    goal=np.array([1.2, -0.5, -0.6]),
)
ARMS = (TWO_JOINTS, THREE_JOINTS)
