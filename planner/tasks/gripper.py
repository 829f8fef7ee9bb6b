"""The gripper of a robot: the joint values that open and close it, how wide it opens, which links grasp."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import pinocchio as pin

from planner.base.errors import choices
from planner.kinematics.forward import tool_joint
from planner.robot.files import urdf
from planner.robot.robot import Robot
from planner.tasks.file import GripperSaid, TaskError


@dataclass(frozen=True)
class Gripper:
    """``open`` and ``closed`` are joint values (rad, m), none where the robot has no such joints.

    ``opening`` (m) is the widest, None where nobody knows; ``touch`` are the links that may touch what is grasped.
    """

    open: Mapping[str, float]
    closed: Mapping[str, float]
    opening: float | None
    touch: tuple[str, ...]

    def values(self, opening: float | None) -> dict[str, float]:
        """The joint values of a grasp at an ``opening`` (m): as far closed as it says, wholly where it says nothing."""
        share = 0.0 if opening is None or not self.opening else min(opening / self.opening, 1.0)
        return {name: low + share * (self.open.get(name, low) - low) for name, low in self.closed.items()}


def gripper_of(robot: Robot, said: GripperSaid) -> Gripper:
    """What a task says, and for the rest what the robot shows: joints that slide, are held and hang behind the tool.

    They are taken to close at their lower limit, and to open, all of them together, by what their limits allow. The
    links that they move may touch; where there are none those that the tool's last joint carries, but for the first.
    """
    model, (last, _) = urdf.build_model(robot.source), tool_joint(robot)
    joints = {name: model.getJointId(name) for name in robot.fixed_joints}
    ends = list(zip(model.lowerPositionLimit.tolist(), model.upperPositionLimit.tolist(), strict=True))
    limits = {name: ends[model.idx_qs[k]] for name, k in joints.items()}
    for values in (said.open or {}, said.closed or {}):
        _require_joints(robot, limits, values)
    links = dict.fromkeys(body.link for body in robot.bodies)
    unknown = sorted(set(said.touch or ()) - set(links))
    if unknown:
        raise TaskError(f"link '{unknown[0]}' cannot touch what is grasped: links with shapes are {choices(links)}.")
    hand = model.getJointId(robot.model.names[last]) if last else 0
    slides = [name for name, k in joints.items() if model.joints[k].shortname().startswith("JointModelP")]
    fingers = [name for name in slides if hand in model.supports[joints[name]]]
    tight, wide = ({name: limits[name][end] for name in fingers} for end in (0, 1))
    frames = [(f.name, model.supports[f.parentJoint]) for f in model.frames if f.type == pin.FrameType.BODY]
    moved = [link for name in fingers for link, path in frames if joints[name] in path and link in links]
    return Gripper(
        wide if said.open is None else said.open,
        tight if said.closed is None else said.closed,
        (sum(wide.values()) - sum(tight.values()) or None) if said.opening is None else said.opening,
        (tuple(dict.fromkeys(moved)) or _at_tool(robot)) if said.touch is None else said.touch,
    )


def _require_joints(robot: Robot, limits: Mapping[str, tuple[float, float]], values: Mapping[str, float]) -> None:
    """Raise :class:`TaskError` for joints that are not held, or values beyond their limits."""
    for name, value in values.items():
        if name not in limits:
            held = choices(sorted(limits))
            raise TaskError(f"the gripper cannot move '{name}': joints of {robot.name} that are held are {held}.")
        low, high = limits[name]
        if not low - 1e-9 <= value <= high + 1e-9:
            raise TaskError(
                f"the gripper moves '{name}' to {value:g}, outside its limits [{low:g}, {high:g}] (rad, m)."
            )


def _at_tool(robot: Robot) -> tuple[str, ...]:
    last, _ = tool_joint(robot)
    links = tuple(dict.fromkeys(body.link for body in robot.bodies if body.joint == last and body not in robot.carried))
    return links[1:] or links
