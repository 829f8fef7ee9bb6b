"""Where the arm should be, as people write it.

A state is a name from the scene, ``q:0.1,-0.4,...`` (joints, rad), ``xyz:0.92,-0.10,0.42`` (tool position, m) or
``pose:x,y,z,qx,qy,qz,qw`` (tool position and orientation). :mod:`planner.query.resolve` finds the configuration.

A goal with tolerance is written as conditions with ``&`` between, see :mod:`planner.problem.conditions`, of which
``xyz:`` and ``pose:`` may be one: ``xyz:0.5,0.3,0.6 & axis:z,0,0,-1`` has the tool's z axis point down there, turning
about it is free.

The name ``home`` is always known: the scene's own state of that name, or else the robot's home, which is what its
robot.yaml says, or where that says nothing (as of a URDF by path) all joints at zero, or at the limit next to zero.

A state of the scene may be the name of another, as in ``start: home``.

Alternative goals are written with ``;`` between, names also with commas: ``xyz:0.5,0.3,0.6;home``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass
from typing import TypeAlias

from planner.base.errors import OptionError, StateError, choices
from planner.problem.conditions import AND as AND  # between alternative goals too
from planner.problem.conditions import FORMS as CONDITIONS
from planner.problem.conditions import (
    Condition,
    KeepBox,
    KeepTurn,
    is_condition,
    parse_condition,
)

HOME = "home"
BOTH = "&"  # between the conditions of one goal
_MOST_NAMES = 100  # that a state may lead through, or to
TURN = 2 * math.pi * (1 + 1e-4)  # rad: a whole turn, however it was rounded
FORMS = "a name from the scene, q:..., xyz:x,y,z, pose:x,y,z,qx,qy,qz,qw or conditions such as axis:z,0,0,-1,0.1"


@dataclass(frozen=True)
class Joints:
    """Joint values, rad (m where prismatic)."""

    values: tuple[float, ...]


@dataclass(frozen=True)
class Position:
    """A place for the origin of the tool, or of another ``frame``, m; its orientation is free."""

    xyz: tuple[float, ...]
    frame: str | None = None


@dataclass(frozen=True)
class Pose:
    """A placement of the tool frame, or of another ``frame``: position in m, orientation as a quaternion x, y, z, w."""

    xyz: tuple[float, ...]
    quaternion: tuple[float, ...]
    frame: str | None = None


@dataclass(frozen=True)
class ToolGoal:
    """All that meets ``conditions`` on the tool, or on other frames: a goal with tolerance.

    planner.ToolGoal((planner.KeepBox((0.5, 0.3, 0.6), (0.5, 0.3, 0.7)), planner.KeepAxis("z", (0.0, 0.0, -1.0), 0.1)))

    One of a turn without a quaternion means the orientation at the start.
    """

    conditions: tuple[Condition, ...]

    def __post_init__(self) -> None:
        if not self.conditions:
            raise OptionError("a goal of the tool has no condition: give one or more on its pose.")

    @property
    def text(self) -> str:
        """As people write it."""
        return f" {BOTH} ".join(each.text for each in self.conditions)


@dataclass(frozen=True)
class Named:
    """States that the scene names; more than one are alternatives."""

    names: tuple[str, ...]


Target: TypeAlias = Joints | Position | Pose | ToolGoal | Named


FARTHEST_BASE = 1e4  # m: as far as anything may stand in a scene file


def parse_target(text: str) -> Target:
    """A target out of its text; :class:`OptionError` where the text has no meaning.

    What the robot has to judge (how many joints, limits, reach, NaN) is left to :func:`planner.query.resolve.resolve`.
    """
    kind, colon, rest = text.partition(":")
    if BOTH in text or is_condition(text):
        return ToolGoal(tuple(each for part in text.split(BOTH) for each in _conditions(part.strip())))
    if not colon:
        names = tuple(part.strip() for part in text.split(","))
        if not all(names):
            raise OptionError(f"an empty state is not usable: give {FORMS}.")
        return Named(names)
    match kind:
        case "q":
            return Joints(_numbers(text, rest))
        case "xyz":
            return Position(_numbers(text, rest, 3))
        case "pose":
            values = _numbers(text, rest, 7)
            return Pose(values[:3], values[3:])
    raise OptionError(f"state '{text[:100]}' starts with '{kind[:100]}:': give {FORMS}.")


def _conditions(text: str) -> tuple[Condition, ...]:
    """A part of a goal with tolerance as conditions."""
    if is_condition(text):
        return (parse_condition(text),)
    match parse_target(text):
        case Position((x, y, z)):
            return (KeepBox((x, y, z), (x, y, z)),)
        case Pose((x, y, z), (a, b, c, d)):
            return KeepBox((x, y, z), (x, y, z)), KeepTurn(0.0, (a, b, c, d))
    raise OptionError(f"'{text[:100]}' is no part of a goal with tolerance: give xyz:, pose:, or {CONDITIONS}.")


def state_text(state: str | Iterable[float] | ToolGoal, role: str = "state") -> str:
    """A state as its text, however it is given; :class:`OptionError` for what is none."""
    return state if isinstance(state, str) else state.text if isinstance(state, ToolGoal) else joints_text(state, role)


def joints_text(values: Iterable[float], role: str = "state") -> str:
    """Joint values (dof,) rad as their text, exact to the last bit; :class:`OptionError` for anything else."""
    try:
        row = [] if isinstance(values, bytes | bytearray | Set | Mapping) else list(values)
        if not row or any(isinstance(value, str) or type(value).__name__ in ("bool", "bool_") for value in row):
            raise TypeError
        return "q:" + ",".join(repr(float(value)) for value in row)
    except (TypeError, ValueError):
        given = " ".join(repr(values).split())[:100]
        raise OptionError(f"{role} {given} is not usable: give one row of joint values (rad), or {FORMS}.") from None


def parse_targets(text: str) -> list[tuple[str, Target]]:
    """Alternative goals out of their text, each with its own text; :class:`OptionError` as :func:`parse_target`."""
    found: list[tuple[str, Target]] = []
    for part in (part.strip() for part in text.split(AND)):
        target = parse_target(part)
        if isinstance(target, Named):
            found += [(name, Named((name,))) for name in target.names]
        else:
            found.append((part, target))
    return found


def follow(name: str, states: Mapping[str, str], through: tuple[str, ...] = ()) -> list[str]:
    """The texts that a name stands for among ``states``: where these are names too, what those stand for.

    A name that is none of them stands for itself. Raises :class:`StateError` for one that leads back to itself.
    """
    if name in through or len(through) > _MOST_NAMES:
        what = "leads back to itself" if name in through else f"stands behind more than {_MOST_NAMES} names"
        raise StateError(f"state '{name}' of the scene {what}, by {choices(through[:5])}: give numbers.")
    if name not in states:
        return [name]
    target = parse_target(states[name])
    if not isinstance(target, Named):
        return [states[name]]
    found = [text for each in target.names for text in follow(each, states, (*through, name))]
    if len(found) > _MOST_NAMES:
        raise StateError(f"state '{name}' of the scene stands for more than {_MOST_NAMES} states: name fewer.")
    return found


def parse_base(text: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Position (m) and roll, pitch, yaw (rad) of "x,y,z" or "x,y,z,roll,pitch,yaw"; OptionError for other text."""
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if len(values) not in (3, 6) or not all(abs(value) <= FARTHEST_BASE for value in values):
        raise OptionError(
            f"base '{text[:100]}' is no placement: give x,y,z (m) or x,y,z,roll,pitch,yaw (m and rad), numbers with "
            "commas between."
        )
    turn = values[3:] or (0.0, 0.0, 0.0)
    if max(map(abs, turn)) > TURN:
        raise OptionError(f"base '{text[:100]}' turns by more than a full turn: degrees? 90 degrees are 1.5708 rad.")
    return values[:3], turn


def _numbers(text: str, rest: str, count: int | None = None) -> tuple[float, ...]:
    try:
        values = tuple(float(part) for part in rest.split(","))
    except ValueError:
        raise OptionError(
            f"state '{text[:100]}' holds something that is no number: give numbers with commas between."
        ) from None
    if count is not None and len(values) != count:
        kind = text.partition(":")[0]
        raise OptionError(f"state '{text[:100]}' has {len(values)} numbers, '{kind}:' takes {count}.")
    return values
