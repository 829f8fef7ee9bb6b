"""Random linkages in which joints follow others, and where their links are, out of the URDF by Pinocchio alone."""

import tempfile
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from planner.robot.files.robot_files import JointChoice
from planner.robot.robot import Robot
from tests.coal_judge import coal_geometry, coal_transform
from tests.worlds import link_xml

SHAPES = '<box size="0.06 0.05 0.25"/>', '<sphere radius="0.07"/>', '<cylinder radius="0.04" length="0.2"/>'

PALLETIZER = """<robot name="pal">
<link name="base"><collision><geometry><box size=".3 .3 .2"/></geometry></collision></link>
<joint name="j1" type="revolute"><parent link="base"/><child link="col"/><origin xyz="0 0 .3"/><axis xyz="0 0 1"/>
 <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
<link name="col"><collision><geometry><cylinder radius=".08" length=".2"/></geometry></collision></link>
<joint name="j2" type="revolute"><parent link="col"/><child link="upper"/><origin xyz="0 0 .2"/><axis xyz="0 1 0"/>
 <limit lower="-1" upper="1.5" velocity="1" effort="1"/></joint>
<link name="upper"><collision><origin xyz="0 0 .35"/><geometry><box size=".06 .06 .5"/></geometry></collision></link>
<joint name="rod_joint" type="revolute"><parent link="col"/><child link="rod"/><origin xyz="-.15 0 .2"/>
 <axis xyz="0 1 0"/><limit lower="-1" upper="1.5" velocity="1" effort="1"/><mimic joint="j2"/></joint>
<link name="rod"><collision><origin xyz="0 0 .35"/><geometry><box size=".03 .03 .6"/></geometry></collision></link>
<joint name="j3" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0 0 .7"/><axis xyz="0 1 0"/>
 <limit lower="-1" upper="1.5" velocity="1" effort="1"/></joint>
<link name="fore"><collision><origin xyz=".25 0 0"/><geometry><box size=".4 .06 .06"/></geometry></collision></link>
<joint name="level_2" type="revolute"><parent link="fore"/><child link="bar"/><origin xyz=".6 0 0"/><axis xyz="0 1 0"/>
 <limit lower="-2" upper="2" velocity="2" effort="1"/><mimic joint="j2" multiplier="-1"/></joint>
<link name="bar"/>
<joint name="level_3" type="revolute"><parent link="bar"/><child link="tcp"/><axis xyz="0 1 0"/>
 <limit lower="-2" upper="2" velocity="2" effort="1"/><mimic joint="j3" multiplier="-1"/></joint>
<link name="tcp"><collision><origin xyz="0 0 -.06"/><geometry><box size=".08 .08 .1"/></geometry></collision></link>
</robot>
"""  # a rod that goes with the upper arm, and a tool that two followers keep level


@dataclass(frozen=True, eq=False)
class Linkage:
    """A robot with followers, and its URDF as Pinocchio reads it, all of its joints free."""

    path: Path
    robot: Robot
    model: Any
    geometry: Any

    def values(self, q: np.ndarray) -> np.ndarray:
        """The values of all joints, as the URDF's <mimic> say."""
        known = dict(zip(self.robot.joints, q, strict=True))
        mimics = {joint.get("name"): joint.find("mimic") for joint in ET.parse(self.path).iter("joint")}

        def value(name: str) -> float:
            said = mimics.get(name)
            if said is None:
                return float(known.get(name, 0.0))
            leader = value(said.get("joint", ""))
            return float(said.get("multiplier", 1)) * leader + float(said.get("offset", 0))

        return np.array([value(name) for name in self.model.names[1:]])

    def frames(self, q: np.ndarray) -> dict[str, np.ndarray]:
        """The placements (4, 4) of all links at a configuration (dof,)."""
        data = self.model.createData()
        pin.framesForwardKinematics(self.model, data, self.values(q))
        return {
            frame.name: data.oMf[k].homogeneous
            for k, frame in enumerate(self.model.frames)
            if frame.type == pin.FrameType.BODY
        }

    def nearest(self, world: Any, states: np.ndarray, but: str = "") -> float:
        """The smallest distance (m) of a checked pair of a world in any of the states (n, dof), by coal.

        Pairs of the link ``but`` do not count.
        """
        shapes = {item.name: item for item in self.geometry.geometryObjects}
        obstacles = [(coal_geometry(item.shape), coal_transform(item.placement)) for item in world.obstacles]
        data, placed, least = self.model.createData(), self.geometry.createData(), np.inf
        pairs = [(*world.members(k), world.is_scene_pair(k)) for k in range(len(world.pair_reach))]
        pairs = [(a, b, scene) for a, b, scene in pairs if not scene or world.checked[a, b]]
        pairs = [pair for pair in pairs if world.bodies[pair[0]].link != but]
        for q in states:
            pin.updateGeometryPlacements(self.model, data, self.geometry, placed, self.values(q))
            there = {
                name: (shapes[name].geometry, coal_transform(placed.oMg[k].homogeneous))
                for k, name in enumerate(shapes)
            }
            for a, b, scene in pairs:
                one, other = there[world.bodies[a].name], obstacles[b] if scene else there[world.bodies[b].name]
                gap = coal.distance(*one, *other, coal.DistanceRequest(), coal.DistanceResult())
                least = min(least, gap)
        return least


def linkage_of(text: str, tool: str, joints: tuple[str, ...] | None = None) -> Linkage:
    """The linkage of a URDF's text; joints that turn without end count as turning once, as in the planner."""
    path = Path(tempfile.mkdtemp()) / "linkage.urdf"
    path.write_text(text)
    model = pin.buildModelFromXML(text.replace('type="continuous"', 'type="revolute"'))
    geometry = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
    return Linkage(path, Robot.load(path, tool=tool, choice=JointChoice(joints=joints)), model, geometry)


@cache
def palletizer() -> Linkage:
    """Three followers: a rod that is no part of the chain, and two joints that keep the tool level."""
    return linkage_of(PALLETIZER, "tcp")


@cache
def random_linkage(seed: int) -> Linkage:
    """Four to six joints in a tree, of which one to three follow others, some by way of another follower.

    Some come before their leaders, in the tree and in Pinocchio's order.
    """
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 7))
    names = [f"{letter}{k}" for k, letter in enumerate(rng.permutation(list("abcdefgh"))[:count])]
    led = {int(k) for k in rng.permutation(count)[: int(rng.integers(1, 4))]}
    free = [k for k in range(count) if k not in led]
    text, done = link_xml("l0", SHAPES[0]), list(free)
    said = {}
    for k in led:
        leader = done[int(rng.integers(len(done)))]
        done.append(k)
        said[k] = f'<mimic joint="{names[leader]}" multiplier="{_factor(rng)!r}" offset="{rng.uniform(-0.5, 0.5)!r}"/>'
    for k, name in enumerate(names):
        kind = "prismatic" if rng.random() < 0.3 else "revolute"
        below = int(rng.integers(max(0, k - 1), k + 1))
        axis, (x, y, z) = rng.normal(size=3), rng.uniform(-0.3, 0.3, 3)
        most = 20.0 if k in led else 0.3 if kind == "prismatic" else 2.0
        most = 9.0 if kind == "prismatic" and k in led else most
        text += (
            f'<joint name="{name}" type="{kind}"><parent link="l{below}"/><child link="l{k + 1}"/>'
            f'<axis xyz="{axis[0]} {axis[1]} {axis[2]}"/><origin xyz="{x} {y} {z}" rpy="{x} {y} {z}"/>'
            f'<limit lower="{-most}" upper="{most}" velocity="1" effort="1"/>{said.get(k, "")}</joint>'
        )
        text += link_xml(f"l{k + 1}", SHAPES[int(rng.integers(3))], f'<origin xyz="{z} {x} {y}"/>')
    return linkage_of(f'<robot name="linkage">{text}</robot>', f"l{count}", tuple(names[k] for k in free))


def _factor(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0, 2.0, rng.uniform(-1.5, 1.5)]))
