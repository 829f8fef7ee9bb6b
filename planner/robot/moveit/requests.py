"""MotionPlanRequest messages: start, goals and path constraints for a robot in a scene."""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.errors import Note, OptionError, SceneError, StateError, choices
from planner.base.files import StrPath
from planner.base.yamlfile import parse_yaml, quote, read_text, suggest_name
from planner.problem.conditions import (
    AxisConstraint,
    BoxConstraint,
    Condition,
    OrientationConstraint,
    PlaneConstraint,
    require_thick,
)
from planner.problem.targets import Joints, Target, ToolGoal
from planner.robot.files.robot_files import ALL_JOINTS, JointChoice, RobotFiles
from planner.robot.moveit.messages import (
    Constraints,
    MotionPlanRequestMessage,
    Solids,
    read_message,
)
from planner.robot.moveit.messages import (
    OrientationConstraint as OrientationMessage,
)
from planner.robot.moveit.scenes import read_attached
from planner.robot.poses import pose, quaternion_of
from planner.robot.robot import Robot
from planner.robot.robot_in_scene import placement_of_frame
from planner.robot.scene import Scene
from planner.robot.shapes import Carried

_SAME = 1e-6  # rad, m: tolerance of a held joint at a goal
_RIGHT = 0.5 * math.pi


@dataclass(frozen=True)
class MotionPlanRequest:
    """Start by joint names, carried shapes, alternative goals, path constraints, limit scales.

    ``group`` is empty if not given. A start that ``replaces`` the scene's is not a difference to it.
    """

    where: str
    start: Mapping[str, float]
    goals: tuple[Constraints, ...]
    path: Constraints
    group: str
    carried: tuple[Carried, ...]
    replaces: bool
    shares: Mapping[str, float]
    notes: tuple[Note, ...]


def read_motion_plan_request(path: StrPath) -> MotionPlanRequest:
    """Return the request at ``path``; :class:`SceneError` for invalid files and unsupported fields."""
    path = Path(path)
    where = f"MotionPlanRequest {path}"
    data = parse_yaml(read_text(path, "MotionPlanRequest"), where)
    message, notes = read_message(MotionPlanRequestMessage, data, where)
    start, goals, along_path = message.start_state, message.goal_constraints, message.path_constraints
    factors = {kind: getattr(message, f"max_{kind}_scaling_factor") for kind in ("velocity", "acceleration")}
    if wrong := [kind for kind, factor in factors.items() if not 0.0 <= factor <= 1.0]:
        notes += (Note(f"{where}: scaling of {choices(wrong)} outside (0, 1] is taken as 1, as MoveIt does."),)
    simpler = ["path_constraints"] if along_path.is_simplified else []
    for k, goal in enumerate(goals, start=1):
        if goal.is_simplified or any(each.tolerance_above or each.tolerance_below for each in goal.joint_constraints):
            simpler.append(f"goal {k}")
    if simpler:
        text = f"of tolerances that are no box a simpler part inside them is followed: {choices(simpler)}."
        notes += (Note(f"{where}: {text}", grave=False),)
    return MotionPlanRequest(
        where,
        start.joint_state.values(),
        tuple(goals),
        along_path,
        message.group_name,
        read_attached(start.attached_collision_objects, where),
        not start.is_diff,
        {kind: min(factor, 1.0) for kind, factor in factors.items() if factor > 0.0},
        notes,
    )


def with_start_state(scene: Scene, message: MotionPlanRequest | None) -> Scene:
    """Return the scene with the objects that the request's start attaches, and with its notes.

    Without a request, a note names scene content that only a request uses.
    """
    if message is None:
        if scene.message is None or not scene.message.state:
            return scene
        text = f"robot_state.joint_state of scene '{scene.name}' counts with a request only, and is passed over."
        return replace(scene, notes=tuple(dict.fromkeys((*scene.notes, Note(text, grave=False)))))
    names = {item.object for item in message.carried}
    still_carried = tuple(item for item in scene.carried if item.object not in names)
    notes = message.notes
    if still_carried and message.replaces:
        held = choices(dict.fromkeys(item.object for item in still_carried))
        text = f"its start_state is no difference (is_diff), so MoveIt would let go of {held}; it is still carried here"
        notes += (Note(f"{message.where}: {text}."),)
    if both := sorted(names & {item.object for item in scene.obstacles}):
        raise SceneError(
            f"{message.where}: {quote(both[0])} is attached, and stands in scene {quote(scene.name)} too; take it out "
            "of one of them."
        )
    notes = tuple(dict.fromkeys((*scene.notes, *notes)))
    return replace(scene, carried=(*still_carried, *message.carried), notes=notes)


def choose_joints(message: MotionPlanRequest, given: JointChoice, files: RobotFiles) -> JointChoice:
    """Return the joint choice ``given``, or else the request's group if the SRDF has it."""
    known = files.srdf is not None and message.group in files.srdf.groups
    return JointChoice(message.group) if given == ALL_JOINTS and known else given


def start_values(message: MotionPlanRequest, scene: Scene) -> dict[str, float]:
    """Return joint values by name: the request's, else the scene's."""
    start = {**(scene.message.state if scene.message else {}), **message.start}
    if not start:
        raise SceneError(f"{message.where} has no start state; add start_state.joint_state.")
    return start


def request_notes(message: MotionPlanRequest, robot: Robot, choice: JointChoice) -> Iterator[Note]:
    """Yield notes on values of a request that the robot cannot use."""
    where, known = message.where, {name: value for name, value in message.start.items() if name in robot.source.joints}
    if lacking := [name for name in message.start if name not in known]:
        text = f"{where}: its start_state names joints that the robot lacks, passed over: {choices(lacking)}."
        yield Note(text, grave=False)
    held = {name: value for name, value in known.items() if name not in robot.joints}
    if other := [name for name, value in held.items() if abs(_value_of_unplanned(name, robot, known) - value) > _SAME]:
        yield Note(f"{where}: the robot holds {choices(other)} elsewhere than start_state says.")
    named = [{each.joint_name for each in goal.joint_constraints} for goal in message.goals]
    if message.group and choice == ALL_JOINTS and not all(set(robot.joints) <= names for names in named):
        yield Note(
            f"{where}: group_name {quote(message.group)} is no group that the robot knows; planned are "
            f"{choices(robot.joints)}."
        )


def start_joints(message: MotionPlanRequest, robot: Robot, scene: Scene) -> Joints:
    """Return the start of the planned joints."""
    return _values_of_planned(start_values(message, scene), robot, "start")


def goal_targets(message: MotionPlanRequest, robot: Robot, scene: Scene) -> list[Target]:
    """Return the goals: joint values, or conditions on links with one target per choice of regions."""
    start, targets = start_values(message, scene), list[Target]()
    for k, goal in enumerate(message.goals, start=1):
        where = f"{message.where}: goal {k}"
        places = [each.constraint_region.solids() for each in goal.position_constraints]
        if goal.joint_constraints and (places or goal.orientation_constraints):
            raise SceneError(f"{where} constrains joints and a link at once; give one of the two.")
        if goal.joint_constraints:
            targets.append(_joint_target(goal, robot, start, where))
            continue
        if not all(places) or not (places or goal.orientation_constraints):
            raise SceneError(f"{where} has neither joint nor position nor orientation constraints; add one of them.")
        for solids in itertools.product(*places):
            targets.append(ToolGoal(tuple(_conditions(goal, solids, robot, scene, where))))
    return targets


def path_conditions(message: MotionPlanRequest, robot: Robot, scene: Scene) -> tuple[Condition, ...]:
    """Return the conditions of the request's path constraints on links."""
    where = f"{message.where}: path_constraints"
    places = [each.constraint_region.solids() for each in message.path.position_constraints]
    if any(len(solids) != 1 or solids[0][0] not in ("box", "sphere") for solids in places):
        raise SceneError(
            f"{where} has a position constraint on a region that is no single box or sphere, which is not supported: "
            "give one of these."
        )
    try:
        solids = tuple(solid for (solid,) in places)
        return require_thick(tuple(_conditions(message.path, solids, robot, scene, where)))
    except OptionError as error:
        raise SceneError(f"{where}: {error}") from None


def with_path_limits(robot: Robot, message: MotionPlanRequest, scene: Scene) -> Robot:
    """Return the robot with limits narrowed to the joint ranges of the path constraints."""
    lower, upper, where = robot.lower.copy(), robot.upper.copy(), f"{message.where}: path_constraints"
    for each in message.path.joint_constraints:
        name, low, high = each.joint_name, each.position - each.tolerance_below, each.position + each.tolerance_above
        for item in robot.followers:
            if item.joint == name:
                name = item.leader
                low, high = sorted((end - item.offset) / item.multiplier for end in (low, high))
        if name not in robot.joints:
            _require_held(name, each.position, (low, high), robot, start_values(message, scene), where)
            continue
        k = robot.joints.index(name)
        lower[k], upper[k] = max(lower[k], low), min(upper[k], high)
        if robot.continuous[k] or not lower[k] < upper[k]:
            own = "turns without end" if robot.continuous[k] else f"has [{robot.lower[k]:.6g}, {robot.upper[k]:.6g}]"
            text = f"keeps joint '{name}' to [{low:.6g}, {high:.6g}], and it {own}: give a range within its limits."
            raise SceneError(f"{where} {text}")
    if not message.path.joint_constraints:
        return robot
    return replace(robot, lower=frozen(lower), upper=frozen(upper), home=frozen(np.clip(robot.home, lower, upper)))


def _conditions(item: Constraints, solids: Solids, robot: Robot, scene: Scene, where: str) -> Iterator[Condition]:
    """Yield position constraints, each with one solid, and orientation constraints, in the scene's frame."""
    for each, (kind, dimensions, placement) in zip(item.position_constraints, solids, strict=True):
        frame = _moving_frame(each.link_name, robot, where)
        at = placement_of_frame(each.header.frame_id, robot, scene, where) @ placement
        yield from _position_conditions(kind, dimensions, at, frame=frame, point=each.target_point_offset)
    for turn in item.orientation_constraints:
        frame = _moving_frame(turn.link_name, robot, where)
        at = placement_of_frame(turn.header.frame_id, robot, scene, where) @ pose(quaternion=turn.orientation)
        yield from _orientation_conditions(turn, at[:3, :3], frame)


def _position_conditions(kind: str, dimensions: Sequence[float], at: Floats, **of: Any) -> Iterator[Condition]:
    """Yield conditions for a point in a box ``at`` (4, 4), in the cube inside a sphere, else at a centre."""
    sizes = {"box": dimensions, "sphere": [2.0 * dimensions[0] / math.sqrt(3.0)] * 3 if dimensions else []}
    half = 0.5 * np.array(sizes.get(kind, [0.0] * 3))
    if kind != "box" or np.array_equal(at[:3, :3], np.eye(3)):
        yield BoxConstraint(tuple(at[:3, 3] - half), tuple(at[:3, 3] + half), **of)
        return
    for axis, size in zip(at[:3, :3].T, half.tolist(), strict=True):
        for normal in (axis, -axis):
            yield PlaneConstraint(tuple(normal), float(normal @ at[:3, 3]) - size, **of)


def _orientation_conditions(turn: OrientationMessage, matrix: Floats, frame: str | None) -> Iterator[Condition]:
    """Yield the cone about an axis and the rotation bound inside tolerances about ``matrix`` (3, 3).

    With M = R0ᵀ R the intrinsic angles about x, y, z are atan2(-M12, M22), asin M02 and atan2(-M01, M00). If the z axes
    are within a <= pi / 2, the angles about x and y are at most a; if the x axes are, those about y and z; a rotation
    by b bounds all three. The components of a rotation vector of length v <= b across axis k are at most v sin(c / 2) /
    sin(v / 2), where c is the angle between the axes k, and x / sin(x / 2) increases up to pi.
    """
    tolerances = np.minimum(turn.tolerances, math.pi)
    euler = turn.parameterization == 0
    if euler and tolerances[1] >= _RIGHT:
        tolerances[1] = math.pi  # the angle about y never exceeds pi / 2
    if min(tolerances) >= math.pi:
        return
    k = max((0, 2) if euler else (0, 1, 2), key=lambda axis: tolerances[axis])
    about, least = float(tolerances[k]), float(min(np.delete(tolerances, k)))
    if least < about:
        angle = min(least, _RIGHT) if euler else 2.0 * math.asin(least * math.sin(0.5 * about) / about)
        yield AxisConstraint("xyz"[k], tuple(matrix[:, k]), angle, frame=frame)
    if about < math.pi:
        x, y, z, w = quaternion_of(matrix)
        yield OrientationConstraint(min(about, _RIGHT) if euler else about, (x, y, z, w), frame=frame)


def _values_of_planned(values: Mapping[str, float], robot: Robot, role: str) -> Joints:
    if missing := [joint for joint in robot.joints if joint not in values]:
        raise StateError(
            f"the request's {role} must give all planned joints, got none of {choices(missing)}: choose the request's "
            "--robot."
        )
    return Joints(tuple(values[joint] for joint in robot.joints))


def _joint_target(goal: Constraints, robot: Robot, start: Mapping[str, float], where: str) -> Joints:
    """Return the planned joints of a goal; :class:`StateError` if it moves joints that are held."""
    values = {each.joint_name: each.position for each in goal.joint_constraints}
    if len(values) < len(goal.joint_constraints):
        raise SceneError(f"{where} constrains a joint twice, one of {choices(values)}; give one constraint a joint.")
    planned = _values_of_planned(values, robot, "goal")
    for each in goal.joint_constraints:
        if each.joint_name not in robot.joints:
            low, high = (max(tolerance, _SAME) for tolerance in (each.tolerance_below, each.tolerance_above))
            within = each.position - low, each.position + high
            _require_held(each.joint_name, each.position, within, robot, {**start, **values}, "the request's goal")
    return planned


def _require_held(
    name: str, value: float, within: tuple[float, float], robot: Robot, values: Mapping[str, float], what: str
) -> None:
    """Raise :class:`StateError` if an unplanned joint is not held ``within`` a constraint's range."""
    held = _value_of_unplanned(name, robot, values) if name in robot.source.joints else values.get(name)
    if held is None:
        raise StateError(
            f"{what} names joint '{name}'{suggest_name(name, robot.joints)}, which the robot lacks; choose "
            "--robot, or take the constraint out."
        )
    if not within[0] <= held <= within[1]:
        raise StateError(
            f"{what} wants joint '{name}' at {value:g}, but it is not planned, and held at {held:g}; "
            "plan it too (--group or --joints), or take the constraint out."
        )


def _value_of_unplanned(name: str, robot: Robot, values: Mapping[str, float]) -> float:
    """Return the value of a held joint or follower; NaN if ``values`` lack its leader."""
    for item in robot.followers:
        if item.joint == name:
            return item.multiplier * values.get(item.leader, np.nan) + item.offset
    return robot.fixed_joints.get(name, 0.0)


def _moving_frame(link: str, robot: Robot, where: str) -> str | None:
    """Return the frame of a constraint's link, None for the tool; :class:`SceneError` if it does not move."""
    if link in ("", robot.tool):
        return None
    frames = [frame for frame in robot.model.frames if frame.name == link]
    if not frames:
        raise SceneError(f"{where} is for link {quote(link)}, which robot '{robot.name}' lacks; name a link of it.")
    if all(frame.parentJoint == 0 for frame in frames):
        raise SceneError(f"{where} is for link {quote(link)}, which no planned joint moves; name a link that moves.")
    return link
