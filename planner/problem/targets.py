"""Targets of the arm, as people write them.

A state is a name from the scene, ``q:0.1,-0.4,...`` (joints, rad), ``xyz:0.92,-0.10,0.42`` (tool position, m) or
``pose:x,y,z,qx,qy,qz,qw``; :mod:`planner.query.resolve` finds the configuration. ``home`` is the scene's state of that
name, or else the robot's home: that of its robot.yaml, or all joints at zero, or at the limit next to zero.

A goal with tolerance is written as conditions with ``&`` between (:mod:`planner.problem.conditions`), of which ``xyz:``
and ``pose:`` may be one. Each names its frame, the tool by default: ``left_tool xyz:... & right_tool pose:...`` is a
goal for both at once, and ``xyz:... of left_tool`` is the same as ``left_tool xyz:...``. Alternative goals are written
with ``;`` between, names also with commas.

In Python an array (4, 4) or a ``pinocchio.SE3`` is a pose of the tool, one row of numbers is joint values, and a list
holds alternative goals, of four joints too.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Set
from dataclasses import InitVar, dataclass, replace
from numbers import Real
from typing import Any, TypeAlias

import numpy as np

from planner.base.arrays import is_placement, placement
from planner.base.errors import OptionError, StateError, choices
from planner.problem.conditions import AND as AND  # between alternative goals too
from planner.problem.conditions import FORMS as CONDITIONS
from planner.problem.conditions import (
    BoxConstraint,
    Condition,
    OrientationConstraint,
    is_condition,
    join_frames,
    numbers_text,
    parse_conditions,
    split_frame,
)

HOME = "home"
BOTH = "&"  # between the conditions of one goal
FARTHEST_BASE = 1e4  # m: the largest coordinate of a scene file
TURN = 2 * math.pi * (1 + 1e-4)  # rad: a whole turn with its rounding
_ROBOT = re.compile(r"[A-Za-z_][\w-]*")  # its name, before a colon
FORMS = "a name from the scene, q:..., xyz:x,y,z, pose:x,y,z,qx,qy,qz,qw or conditions such as axis:z,0,0,-1,0.1"


@dataclass(frozen=True)
class Joints:
    """Joint values, rad (m where prismatic)."""

    values: tuple[float, ...]

    @property
    def text(self) -> str:
        """The target as people write it, exact to the last bit."""
        return "q:" + ",".join(repr(float(value)) for value in self.values)


@dataclass(frozen=True)
class Position:
    """A position (m) of the origin of the tool, or of another ``frame``, in any orientation."""

    xyz: tuple[float, ...]
    frame: str | None = None

    @property
    def text(self) -> str:
        return "xyz:" + numbers_text(self.xyz) + _of(self.frame)


@dataclass(frozen=True)
class Pose:
    """A pose of the tool, or of another ``frame``: position (m), quaternion x, y, z, w."""

    xyz: tuple[float, ...]
    quaternion: tuple[float, ...]
    frame: str | None = None

    @property
    def text(self) -> str:
        return "pose:" + numbers_text((*self.xyz, *self.quaternion)) + _of(self.frame)


@dataclass(frozen=True)
class ToolGoal:
    """A goal with tolerance: every configuration that meets ``conditions`` on frames.

        down = planner.AxisConstraint("z", (0.0, 0.0, -1.0), 0.1)
        planner.ToolGoal((planner.BoxConstraint((0.5, 0.3, 0.6), (0.5, 0.3, 0.7)), down))

    A pose, as text, array (4, 4) or ``pinocchio.SE3``, may be one of them. A turn without a quaternion is relative to
    the orientation at the start. ``tool`` is the frame of the conditions that name none. Goals joined by ``&`` hold at
    once, each for its own tool:

        planner.ToolGoal(robot.fk(q), tool="left_tool") & planner.ToolGoal("xyz:0.5,-0.2,0.4", tool="right_tool")
    """

    conditions: tuple[Condition, ...]
    tool: InitVar[str | None] = None

    def __post_init__(self, tool: str | None) -> None:
        given = self.conditions if isinstance(self.conditions, tuple | list) else (self.conditions,)
        if not given:
            raise OptionError("goal of the tool must have one condition or more, got none: give a pose, for example.")
        flat = [each for part in given for each in _conditions(part)]
        framed = tuple(replace(each, frame=each.frame or tool) if tool else each for each in flat)
        object.__setattr__(self, "conditions", framed)

    def __and__(self, other: object) -> ToolGoal:
        """Return the goal of this tool and another one at once."""
        return ToolGoal((self, other))  # type: ignore[arg-type]

    @property
    def text(self) -> str:
        return f" {BOTH} ".join(map(_condition_text, self.conditions))

    @property
    def exact(self) -> tuple[Position | Pose, ...]:
        """The position or pose of each frame, if all conditions are such, else none."""
        by_frame: dict[str | None, list[Condition]] = {}
        for condition in self.conditions:
            by_frame.setdefault(condition.frame, []).append(condition)
        targets: list[Position | Pose] = []
        for frame, conditions in by_frame.items():
            match conditions:
                case [BoxConstraint(at) as box] if box == BoxConstraint(at, at, frame=frame):
                    targets.append(Position(at, frame))
                case [BoxConstraint(at) as box, OrientationConstraint(0.0, quaternion) as turn] if quaternion:
                    whole = box == BoxConstraint(at, at, frame=frame) and not turn.base
                    targets += [Pose(at, quaternion, frame)] if whole else []
        return tuple(targets) if len(targets) == len(by_frame) else ()


@dataclass(frozen=True)
class Named:
    """Named states of the scene; several are alternatives."""

    names: tuple[str, ...]

    @property
    def text(self) -> str:
        return ",".join(self.names)


@dataclass(frozen=True)
class RobotStates:
    """States of single robots of a cell by name; several of one robot are alternatives."""

    states: tuple[tuple[str, Joints | Position | Pose | ToolGoal | Named], ...]

    @property
    def text(self) -> str:
        return AND.join(f"{robot}:{state.text}" for robot, state in self.states)


Target: TypeAlias = Joints | Position | Pose | ToolGoal | Named | RobotStates


def parse_target(text: str) -> Target:
    """Parse a target; :class:`OptionError` for a text of another form.

    :func:`planner.query.resolve.resolve` checks the number of joints, limits, reach and NaN.
    """
    before, body = split_frame(text)
    kind, colon, rest = body.partition(":")
    named_robot = colon and before is None and _ROBOT.fullmatch(kind) and kind not in ("q", "xyz", "pose")
    if named_robot and not is_condition(text):
        return RobotStates(tuple(_robot_state(part.strip()) for part in text.split(AND)))
    if BOTH in text or is_condition(text):
        return ToolGoal(tuple(each for part in text.split(BOTH) for each in _conditions(part.strip())))
    if not colon:
        names = tuple(part.strip() for part in text.split(","))
        if not all(names):
            raise OptionError(f"state must be {FORMS}, got an empty text.")
        return Named(names)
    rest, of, behind = rest.partition(" of ")
    frame = join_frames(text, before, behind.strip() if of else None)
    match kind:
        case "q" if frame is None:
            return Joints(_numbers(text, rest))
        case "xyz":
            return Position(_numbers(text, rest, 3), frame)
        case "pose":
            values = _numbers(text, rest, 7)
            return Pose(values[:3], values[3:], frame)
    raise _not_a_state(text)


def _not_a_state(text: str) -> OptionError:
    return OptionError(f"state must be {FORMS}, got '{text[:100]}'.")


def _robot_state(text: str) -> tuple[str, Joints | Position | Pose | ToolGoal | Named]:
    """Return the robot and its state in a text such as left:home."""
    robot, _, rest = text.partition(":")
    state = parse_target(rest) if rest and _ROBOT.fullmatch(robot) else None
    if state is None or isinstance(state, RobotStates):
        raise _not_a_state(text)
    return robot, state


def _conditions(part: object) -> tuple[Condition, ...]:
    """Return the conditions of one part of a goal with tolerance."""
    if isinstance(part, Condition):
        return (part,)
    if isinstance(part, ToolGoal):
        return part.conditions
    if isinstance(part, str) and is_condition(part):
        return parse_conditions(part)
    match read_target(part, "a part of a goal with tolerance"):
        case Position((x, y, z), frame):
            return (BoxConstraint((x, y, z), (x, y, z), frame=frame),)
        case Pose((x, y, z), (a, b, c, d), frame):
            return BoxConstraint((x, y, z), (x, y, z), frame=frame), OrientationConstraint(
                0.0, (a, b, c, d), frame=frame
            )
    raise OptionError(f"goal with tolerance must consist of xyz:, pose:, {CONDITIONS}, got '{part!s:.100}'.")


def _condition_text(condition: Condition) -> str:
    """Return the text of a condition in a goal; a box of zero size is a position."""
    at, frame = condition.lower if isinstance(condition, BoxConstraint) else (), condition.frame
    return Position(at, frame).text if at and condition == BoxConstraint(at, at, frame=frame) else condition.text


def _of(frame: str | None) -> str:
    return f" of {frame}" if frame else ""


def _numbers_of(matrix: object, role: str) -> tuple[list[float], list[float], list[float]]:
    """Return position (m), quaternion x, y, z, w, and roll, pitch, yaw (rad) of a (4, 4) placement."""
    import pinocchio as pin  # no text needs it

    rigid = placement(f"the (4, 4) pose given as {role}", matrix, OptionError, FARTHEST_BASE)
    turn = np.array(rigid[:3, :3])
    quaternion = pin.Quaternion(turn).normalized().coeffs()
    return rigid[:3, 3].tolist(), quaternion.tolist(), pin.rpy.matrixToRpy(turn).tolist()


def joints_text(values: Iterable[float]) -> str:
    """Return the text of joint values (dof,) rad."""
    return Joints(tuple(map(float, values))).text


def read_target(state: object, role: str = "state") -> Target:
    """Return a target from a target, text, joint values (dof,) rad, or a pose (4, 4) or ``pinocchio.SE3``.

    :class:`OptionError` for any other value, and for a pose that is not rigid.
    """
    if isinstance(state, Target):
        return state
    if isinstance(state, str):
        return parse_target(state)
    if isinstance(state, Mapping) and state and all(isinstance(robot, str) for robot in state):
        each = [(robot, target) for robot, given in state.items() for target in read_goals(given)]
        return RobotStates(tuple((robot, target) for robot, target in each if not isinstance(target, RobotStates)))
    if is_placement(state):
        (x, y, z), (a, b, c, d), _ = _numbers_of(state, role)
        return Pose((x, y, z), (a, b, c, d))
    try:
        row: list[Any] = [] if isinstance(state, bytes | Set | Mapping) else list(state)  # type: ignore[call-overload]
        if not row or any(isinstance(value, str | bool | np.bool_) for value in row):
            raise TypeError
        return Joints(tuple(map(float, row)))
    except (TypeError, ValueError):
        given = " ".join(repr(state).split())[:100]
        raise OptionError(f"{role} must be one row of joint values (rad), or {FORMS}, got {given}.") from None


def read_goals(goal: object) -> tuple[Target, ...]:
    """Return alternative goals from text, a target, joint values, a pose (4, 4), or a list of these."""
    if isinstance(goal, str):
        return parse_targets(goal)
    if isinstance(goal, tuple | list) and goal and not any(isinstance(each, Real) for each in goal):
        return tuple(target for each in goal for target in read_goals(each))
    return (read_target(goal, "goal"),)


def parse_targets(text: str) -> tuple[Target, ...]:
    """Parse alternative goals, each name a goal; :class:`OptionError` as :func:`parse_target`."""
    targets: list[Target] = []
    for target in (parse_target(part.strip()) for part in text.split(AND)):
        targets += [Named((name,)) for name in target.names] if isinstance(target, Named) else [target]
    return tuple(targets)


def follow_names(name: str, states: Mapping[str, str], through: tuple[str, ...] = ()) -> list[str]:
    """Return the texts of a named state among ``states``, with names among them replaced in turn.

    An unknown name is returned as it is. Raises :class:`StateError` for a name that refers to itself.
    """
    if name in through:
        raise StateError(
            f"state '{name}' of the scene must not refer to itself, got {choices(through[:5])}: give numbers."
        )
    target = parse_target(states[name]) if name in states else None
    if isinstance(target, Named):
        return [text for each in target.names for text in follow_names(each, states, (*through, name))]
    return [states.get(name, name)]


def parse_base(base: Any) -> tuple[float, ...]:
    """Return position (m), and roll, pitch, yaw (rad) if given, of a base from 3 or 6 numbers, or a pose."""
    if is_placement(base):
        position, _, turns = _numbers_of(base, "base")
        return (*position, *turns)
    try:
        values = tuple(float(part) for part in (base.split(",") if isinstance(base, str) else base))
    except (TypeError, ValueError):
        values = ()
    far, turned = (max(map(abs, part), default=0.0) for part in (values[:3], values[3:]))
    if len(values) not in (3, 6) or not (far <= FARTHEST_BASE and turned <= TURN):
        raise OptionError(
            "base must be x,y,z (m) or x,y,z,roll,pitch,yaw (m and rad; 90 degrees are 1.5708), got "
            f"'{str(base)[:100]}': give numbers with commas between."
        )
    return values


def _numbers(text: str, rest: str, count: int | None = None) -> tuple[float, ...]:
    try:
        values = tuple(map(float, rest.split(",")))
    except ValueError:
        raise OptionError(f"state '{text[:100]}' must hold numbers with commas between: give {FORMS}.") from None
    if count is not None and len(values) != count:
        raise OptionError(f"state '{text[:100]}' must have {count} numbers, got {len(values)}: give {FORMS}.")
    return values
