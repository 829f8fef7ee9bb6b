"""What a MoveIt request asks of a robot in a scene: which joints, what they hold and carry, where they go."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import OptionError, SceneError, StateError, choices
from planner.base.notes import Note
from planner.base.yamlfile import nearest, shown
from planner.models.files.robot_files import ALL_JOINTS, JointChoice, RobotFiles
from planner.models.frames import placement_of
from planner.models.poses import pose, quaternion_of
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.problem.conditions import (
    Condition,
    KeepBox,
    KeepEuler,
    KeepJoint,
    KeepPlane,
    KeepRotationVector,
    KeepSphere,
    require_thick,
)
from planner.problem.targets import Joints, Pose, Position, Target, ToolGoal

if TYPE_CHECKING:
    from planner.models.files.moveit.requests import JointGoal, LinkGoal, MotionPlanRequest, Place, RegionGoal

_SAME = 1e-6  # rad, m: a joint that is held where a goal wants it


def in_request(scene: Scene, message: MotionPlanRequest) -> Scene:
    """The scene as the request changes it: what its start attaches is carried, what was passed over is noted."""
    names = {item.object for item in message.carried}
    kept = tuple(item for item in scene.carried if item.object not in names)
    notes = message.notes
    if kept and message.replaces:
        text = (
            f"{message.where}: its start_state is no difference (is_diff), so MoveIt would let go of "
            f"{choices(dict.fromkeys(item.object for item in kept))}; it is carried all the same."
        )
        notes += (Note(text),)
    both = sorted(names & {item.object for item in scene.obstacles})
    if both:
        raise SceneError(
            f"{message.where}: {shown(both[0])} is attached, and stands in scene {shown(scene.name)} too; take it out "
            "of one of them."
        )
    return noting(replace(scene, carried=(*kept, *message.carried)), *notes)


def choice_of(message: MotionPlanRequest, given: JointChoice, files: RobotFiles) -> JointChoice:
    """The joints that are planned: as ``given``, else those of the request's group, where the SRDF has that."""
    known = files.srdf is not None and message.group in files.srdf.groups
    return JointChoice(message.group) if given == ALL_JOINTS and known else given


def start_of(message: MotionPlanRequest, scene: Scene) -> dict[str, float]:
    """Joint values by name: the request's, and where it says nothing the scene's."""
    start = {**(scene.message.state if scene.message else {}), **message.start}
    if not start:
        raise SceneError(f"{message.where} has no joint state to start from; add start_state.joint_state.")
    return start


def unasked(scene: Scene) -> Scene:
    """The scene without a request, which notes what counts only with one."""
    if scene.message is None or not scene.message.state:
        return scene
    text = f"robot_state.joint_state of scene '{scene.name}' counts with a request only, and is passed over."
    return noting(scene, Note(text, grave=False))


def noting(scene: Scene, *notes: Note) -> Scene:
    """The scene with further notes, each once."""
    return replace(scene, notes=tuple(dict.fromkeys((*scene.notes, *notes)))) if notes else scene


def notes_on(message: MotionPlanRequest, robot: Robot, choice: JointChoice) -> tuple[Note, ...]:
    """Notes of what a robot cannot make use of in a request; ``choice`` says who chose the planned joints."""
    lacking = [name for name in message.start if name not in robot.source.joints]
    held = {name: value for name, value in message.start.items() if name not in (*robot.joints, *lacking)}
    start = message.start
    other = [name for name, value in held.items() if abs(_unplanned(name, robot, start) - value) > _SAME]
    found = []
    if lacking:
        text = f"{message.where}: its start_state names joints that the robot lacks, passed over: {choices(lacking)}."
        found.append(Note(text, grave=False))
    if other:
        found.append(Note(f"{message.where}: the robot holds {choices(other)} elsewhere than start_state says."))
    if message.group and choice == ALL_JOINTS and not _names_all(message, robot):
        text = (
            f"{message.where}: group_name {shown(message.group)} is no group that the robot knows; planned are "
            f"{choices(robot.joints)}."
        )
        found.append(Note(text))
    return tuple(found)


def _names_all(message: MotionPlanRequest, robot: Robot) -> bool:
    """Whether every goal names all joints that are planned: then it does not matter what their group is called."""
    return all(set(robot.joints) <= set(getattr(goal, "values", ())) for goal in message.goals)


def joints_of(message: MotionPlanRequest, robot: Robot, scene: Scene) -> Joints:
    """Where the planned joints start."""
    return _planned(start_of(message, scene), robot, "start")


def goals_of(message: MotionPlanRequest, robot: Robot, scene: Scene) -> list[tuple[str, Target]]:
    """The goals with their names: a link's pose as its text, joints by the number of their goal."""
    from planner.models.files.moveit.requests import JointGoal, RegionGoal

    start = start_of(message, scene)
    return [
        (f"number {k}", _joint_target(goal, robot, start))
        if isinstance(goal, JointGoal)
        else _region_target(goal, robot, scene, f"{message.where}: goal {k}")
        if isinstance(goal, RegionGoal)
        else _link_target(goal, robot, scene, f"{message.where}: goal {k}")
        for k, goal in enumerate(message.goals, start=1)
    ]


def kept_of(message: MotionPlanRequest, robot: Robot, scene: Scene) -> tuple[tuple[Condition, ...], tuple[Note, ...]]:
    """What the request's path constraints keep, and notes where a part of that is kept instead of all."""
    where, start = f"{message.where}: path_constraints", start_of(message, scene)
    found = list(_region(message.path, robot, scene, where))
    for each in message.path_joints:
        lower, upper = each.position - each.tolerance_below, each.position + each.tolerance_above
        name = each.joint_name
        for item in robot.followers:
            if item.joint == name:
                name = item.leader
                lower, upper = sorted((end - item.offset) / item.multiplier for end in (lower, upper))
        if name not in robot.joints:
            _require_held(name, each.position, (lower, upper), robot, start, where)
            continue
        try:
            found.append(KeepJoint(name, lower, upper))
        except OptionError as error:
            raise SceneError(f"{where}: {error}") from None
    try:
        require_thick(tuple(found))
    except OptionError as error:
        raise SceneError(f"{where}: {error}") from None
    parts = [each.text for each in found if isinstance(each, KeepEuler) and each.narrowed]
    text = f"{where}: of tolerances that are not convex a convex part is kept: {choices(parts)}."
    return tuple(found), ((Note(text),) if parts else ())


def _region(goal: RegionGoal, robot: Robot, scene: Scene, where: str) -> Iterator[Condition]:
    """Position and orientation constraints as conditions in the scene's own frame."""
    for place in goal.places:
        frame = _moving_frame(place.link, robot, where)
        at = placement_of(place.frame, robot, scene, where) @ place.placement
        yield from _solid(place, at, {"frame": frame, "point": place.offset})
    for turn in goal.turns:
        frame = _moving_frame(turn.link_name, robot, where)
        matrix = placement_of(turn.header.frame_id.removeprefix("/"), robot, scene, where) @ turn.matrix()
        x, y, z, w = quaternion_of(matrix[:3, :3])
        kind = KeepRotationVector if turn.parameterization else KeepEuler
        yield kind(turn.tolerances, quaternion=(x, y, z, w), frame=frame)


def _solid(place: Place, at: Floats, of: dict[str, Any]) -> Iterator[Condition]:
    """A point within a solid that is placed ``at`` (4, 4); at the centre of what is neither box nor sphere."""
    x, y, z = at[:3, 3].tolist()
    if place.kind != "box":
        yield KeepSphere((x, y, z), place.dimensions[0] if place.kind == "sphere" else 0.0, **of)
        return
    half = 0.5 * np.array(place.dimensions[:3])
    if np.array_equal(at[:3, :3], np.eye(3)):
        yield KeepBox(tuple(at[:3, 3] - half), tuple(at[:3, 3] + half), **of)
        return
    for axis, size in zip(at[:3, :3].T, half.tolist(), strict=True):
        for normal in (axis, -axis):
            yield KeepPlane(tuple(normal), float(normal @ at[:3, 3]) - size, **of)


def _planned(values: Mapping[str, float], robot: Robot, role: str) -> Joints:
    missing = [joint for joint in robot.joints if joint not in values]
    if missing:
        raise StateError(
            f"the request's {role} says nothing of {choices(missing)}: it is for another robot; choose --robot."
        )
    return Joints(tuple(values[joint] for joint in robot.joints))


def _joint_target(goal: JointGoal, robot: Robot, start: Mapping[str, float]) -> Joints:
    """The planned joints of a goal; :class:`StateError` where it wants others elsewhere than they are."""
    planned = _planned(goal.values, robot, "goal")
    for name, value in goal.values.items():
        below, above = (max(tolerance, _SAME) for tolerance in goal.tolerances[name])
        if name in robot.joints:
            continue
        _require_held(
            name, value, (value - below, value + above), robot, {**start, **goal.values}, "the request's goal"
        )
    return planned


def _require_held(
    name: str, value: float, within: tuple[float, float], robot: Robot, values: Mapping[str, float], what: str
) -> None:
    """Raise :class:`StateError` where a joint that is not planned is not held ``within`` what a constraint asks."""
    held = _unplanned(name, robot, values) if name in robot.source.joints else values.get(name)
    if held is None:
        raise StateError(
            f"{what} names joint '{name}'{nearest(name, robot.joints)}, which the robot lacks; choose "
            "--robot, or take the constraint out."
        )
    if not within[0] <= held <= within[1]:
        raise StateError(
            f"{what} wants joint '{name}' at {value:g}, but it is not planned, and held at {held:g}; "
            "plan it too (--group or --joints), or take the constraint out."
        )


def _unplanned(name: str, robot: Robot, values: Mapping[str, float]) -> float:
    """The value of a joint that is held or follows another; NaN where ``values`` lack its leader."""
    for item in robot.followers:
        if item.joint == name:
            return item.multiplier * values.get(item.leader, np.nan) + item.offset
    return robot.fixed_joints.get(name, 0.0)


def _link_target(goal: LinkGoal, robot: Robot, scene: Scene, where: str) -> tuple[str, Target]:
    """A goal of a link as a target, in the scene's own frame, with its text."""
    frame = _moving_frame(goal.link, robot, where)
    placement = placement_of(goal.frame, robot, scene, where)
    place = _applied(placement, goal.position)
    of = f" of {frame}" if frame else ""
    if goal.quaternion is None:
        return f"xyz:{_text(place)}{of}", Position(place, frame)
    turn = placement_of(goal.turn_frame, robot, scene, where) @ pose(quaternion=goal.quaternion)
    quaternion = goal.quaternion
    if not np.array_equal(turn, pose(quaternion=goal.quaternion)):
        quaternion = tuple(quaternion_of(turn[:3, :3]))
    if any(goal.offset):
        place = tuple((np.array(place) - turn[:3, :3] @ goal.offset).tolist())
    return f"pose:{_text((*place, *quaternion))}{of}", Pose(place, quaternion, frame)


def _region_target(goal: RegionGoal, robot: Robot, scene: Scene, where: str) -> tuple[str, Target]:
    target = ToolGoal(tuple(_region(goal, robot, scene, where)))
    return target.text, target


def _moving_frame(link: str, robot: Robot, where: str) -> str | None:
    """The frame of a goal's link, None for the tool's own; :class:`SceneError` where the arm does not move it."""
    if link in ("", robot.tool):
        return None
    found = [frame for frame in robot.model.frames if frame.name == link]
    if not found:
        meant = nearest(link, (frame.name for frame in robot.model.frames))
        raise SceneError(
            f"{where} is for link {shown(link)}{meant}, which robot '{robot.name}' has not; name a link of it."
        )
    if all(frame.parentJoint == 0 for frame in found):
        raise SceneError(f"{where} is for link {shown(link)}, which no planned joint moves; name a link that moves.")
    return link


def _applied(placement: Floats, point: Sequence[float]) -> tuple[float, ...]:
    if np.array_equal(placement, np.eye(4)):
        return tuple(point)  # to the last bit
    return tuple((placement[:3, :3] @ point + placement[:3, 3]).tolist())


def _text(values: Sequence[float]) -> str:
    return ",".join(map(repr, values))
