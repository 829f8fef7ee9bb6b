"""The gripper of a robot: the joint values that open and close it, how wide it opens, which links grasp."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import pinocchio as pin

from planner.base.errors import choices
from planner.kinematics.forward import tool_joint
from planner.models.files import urdf
from planner.models.robot import Robot
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
    fingers = _fingers(robot)
    wide = {name: high for name, (_, high, _) in fingers.items()}
    tight = {name: low for name, (low, _, _) in fingers.items()}
    moved = tuple(dict.fromkeys(link for _, _, links in fingers.values() for link in links))
    opening = sum(wide.values()) - sum(tight.values()) or None
    _require_joints(robot, said.open or {})
    _require_joints(robot, said.closed or {})
    links = dict.fromkeys(body.link for body in robot.bodies)
    unknown = sorted(set(said.touch or ()) - set(links))
    if unknown:
        raise TaskError(f"link '{unknown[0]}' cannot touch what is grasped: links with shapes are {choices(links)}.")
    return Gripper(
        wide if said.open is None else said.open,
        tight if said.closed is None else said.closed,
        opening if said.opening is None else said.opening,
        (moved or _at_tool(robot)) if said.touch is None else said.touch,
    )


def _require_joints(robot: Robot, values: Mapping[str, float]) -> None:
    """Raise :class:`TaskError` for joints that are not held, or values beyond their limits."""
    model = urdf.build_model(robot.source) if values else None
    for name, value in values.items():
        if model is None or name not in robot.fixed_joints:
            held = choices(sorted(robot.fixed_joints))
            raise TaskError(f"the gripper cannot move '{name}': joints of {robot.name} that are held are {held}.")
        at = model.joints[model.getJointId(name)].idx_q
        low, high = float(model.lowerPositionLimit[at]), float(model.upperPositionLimit[at])
        if not low - 1e-9 <= value <= high + 1e-9:
            raise TaskError(
                f"the gripper moves '{name}' to {value:g}, outside its limits [{low:g}, {high:g}] (rad, m)."
            )


def _fingers(robot: Robot) -> dict[str, tuple[float, float, tuple[str, ...]]]:
    """Sliding joints that are held and carried by the tool's joint: their limits, and links with shapes they move."""
    if not robot.fixed_joints:
        return {}
    model, (last, _) = urdf.build_model(robot.source), tool_joint(robot)
    hand = model.getJointId(robot.model.names[last]) if last else 0
    shapes, found = {body.link for body in robot.bodies}, {}
    for name in robot.fixed_joints:
        joint = model.getJointId(name)
        if not model.joints[joint].shortname().startswith("JointModelP") or hand not in model.supports[joint]:
            continue
        at = model.joints[joint].idx_q
        moved = [frame for frame in model.frames if joint in model.supports[frame.parentJoint]]
        limits = float(model.lowerPositionLimit[at]), float(model.upperPositionLimit[at])
        found[name] = (*limits, tuple(f.name for f in moved if f.type == pin.FrameType.BODY and f.name in shapes))
    return found


def _at_tool(robot: Robot) -> tuple[str, ...]:
    last, _ = tool_joint(robot)
    links = tuple(dict.fromkeys(body.link for body in robot.bodies if body.joint == last and body not in robot.carried))
    return links[1:] or links
