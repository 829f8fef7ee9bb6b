"""Conditions on a frame of the arm: path constraints of a motion, or the tolerance of a goal.

``axis:z,0,0,1,0.1`` (the tool's z axis within 0.1 rad of a direction of the world), ``box:x0,y0,z0,x1,y1,z1`` (its
origin within, m), ``plane:nx,ny,nz,d`` (n.p >= d) and ``turn:0.1`` (its orientation within 0.1 rad of that at the
start, or of a quaternion: ``turn:0.1,qx,qy,qz,qw``), ``near:0.01`` (its origin within 0.01 m of that at the start, or
of a position: ``near:0.01,x,y,z``). A suffix `` of FRAME``, or ``FRAME `` before the condition, names another frame
than the tool, `` in FRAME`` one that takes the place of the world, and `` at x,y,z`` a point of the frame.
``keep:0.01,0.1`` is ``near:0.01`` and ``turn:0.1``: with two frames, two hands carry one object. ``;`` separates
several conditions.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field
from typing import Annotated, Any, ClassVar, TypeAlias

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field

from planner.base.errors import OptionError
from planner.problem.validation import options

THINNEST = 1e-4  # rad (m): no straight joint motion satisfies a narrower condition
FORMS = "axis:, box:, plane:, turn:, near: or keep:"
AND = ";"  # between conditions
_TURNS = 2.0 * math.pi * (1.0 + 1e-4)  # rad: a larger tolerance is probably in degrees
_UNIT = 1e-3  # tolerance of a quaternion's length
_SYNTAX = re.compile(r"(\w+):(.*?)(?:\s+of\s+(\S+))?(?:\s+in\s+(\S+))?(?:\s+at\s+(\S+))?")
_FRAME_FIRST = re.compile(r"([^\s:]+)\s+(?=\w+:)")


def _direction(vector: tuple[float, ...]) -> tuple[float, ...]:
    if math.hypot(*vector) <= 1e-9:
        raise ValueError("must have a length, as 0,0,1 has")
    return vector


def _unit(quaternion: tuple[float, ...]) -> tuple[float, ...]:
    if abs(math.hypot(*quaternion) - 1.0) > _UNIT:
        raise ValueError("must be of length 1, as qx,qy,qz,qw")
    return quaternion


Number: TypeAlias = Annotated[float, Field(ge=-1e4, le=1e4)]  # rad (m)
Three: TypeAlias = Annotated[tuple[Number, Number, Number], BeforeValidator(tuple)]
Quaternion: TypeAlias = tuple[float, float, float, float]
Angle: TypeAlias = Annotated[float, Field(ge=0, le=_TURNS)]
Direction: TypeAlias = Annotated[Three, AfterValidator(_direction)]


@options
class Condition:
    """A condition on one ``frame`` of the robot, by default the tool.

    Its pose counts in another frame ``base``, by default in the world. ``shape``: the fields in the order of the text,
    and the count of numbers of each.
    """

    frame: str | None = field(default=None, kw_only=True)
    base: str | None = field(default=None, kw_only=True)
    kind: ClassVar[str]
    unit: ClassVar[str] = "rad"
    shape: ClassVar[Mapping[str, int]]

    @property
    def values(self) -> tuple[float, ...]:
        """The numbers in the order of the text."""
        values = [getattr(self, name) for name in self.shape]
        return tuple(np.hstack([each for each in values if each is not None]).tolist())

    @property
    def thickness(self) -> float:
        """The width (rad, m) of the allowed set; inf if it is unbounded."""
        return getattr(self, "angle", math.inf)

    @property
    def text(self) -> str:
        """The condition as people write it, exact to the last bit."""
        axis = f"{self.axis}," if isinstance(self, AxisConstraint) else ""
        frames = (f" of {self.frame}" if self.frame else "") + (f" in {self.base}" if self.base else "")
        return f"{self.kind}:{axis}{numbers_text(self.values)}{frames}"


@options
class OfPoint(Condition):
    """A condition on a ``point`` (m) of a frame, by default its origin."""

    point: Three = field(default=(0.0, 0.0, 0.0), kw_only=True)
    unit: ClassVar[str] = "m"

    @property
    def text(self) -> str:
        return super().text + (f" at {numbers_text(self.point)}" if any(self.point) else "")


@options
class AxisConstraint(Condition):
    """A frame's ``axis`` (x, y or z) within ``angle`` (rad) of a ``direction`` of the world."""

    axis: Annotated[str, Field(pattern="^[xyz]$")]
    direction: Direction
    angle: Annotated[float, Field(ge=0, le=math.pi)] = 0.0
    kind: ClassVar[str] = "axis"
    shape: ClassVar[Mapping[str, int]] = {"direction": 3, "angle": 1}


@options
class BoxConstraint(OfPoint):
    """A frame's origin, or ``point``, between ``lower`` and ``upper`` (m)."""

    lower: Three
    upper: Three
    kind: ClassVar[str] = "box"
    shape: ClassVar[Mapping[str, int]] = {"lower": 3, "upper": 3}

    def __post_init__(self) -> None:
        if self.thickness < 0:
            raise OptionError("lower corner of a box must lie below the upper one: give x0,y0,z0,x1,y1,z1.")

    @property
    def thickness(self) -> float:
        return min(high - low for low, high in zip(self.lower, self.upper, strict=True))


@options
class PlaneConstraint(OfPoint):
    """A frame's origin, or ``point``, p with ``normal`` . p >= ``distance`` (m)."""

    normal: Direction
    distance: Number
    kind: ClassVar[str] = "plane"
    shape: ClassVar[Mapping[str, int]] = {"normal": 3, "distance": 1}


@options
class PositionConstraint(OfPoint):
    """A frame's origin, or ``point``, within ``radius`` (m) of a ``position``, by default the start's."""

    radius: Annotated[float, Field(ge=0, le=1e4)]
    position: Three | None = None
    kind: ClassVar[str] = "near"
    shape: ClassVar[Mapping[str, int]] = {"radius": 1, "position": 3}

    @property
    def thickness(self) -> float:
        return self.radius


@options
class OrientationConstraint(Condition):
    """A frame's orientation within ``angle`` (rad) of a quaternion (x, y, z, w), by default the start's."""

    angle: Angle
    quaternion: Annotated[Quaternion, BeforeValidator(tuple), AfterValidator(_unit)] | None = None
    kind: ClassVar[str] = "turn"
    shape: ClassVar[Mapping[str, int]] = {"angle": 1, "quaternion": 4}


# of each kind: its class, the allowed counts of numbers, and the form of the text
_KINDS: dict[str, tuple[type[Condition], tuple[int, ...], str]] = {
    "axis": (AxisConstraint, (3, 4), "x, y or z, then nx,ny,nz,angle"),
    "box": (BoxConstraint, (6,), "x0,y0,z0,x1,y1,z1"),
    "plane": (PlaneConstraint, (4,), "nx,ny,nz,d"),
    "turn": (OrientationConstraint, (1, 5), "angle or angle,qx,qy,qz,qw"),
    "near": (PositionConstraint, (1, 4), "radius or radius,x,y,z"),
}
_KEEP = "keep"  # a position and an orientation at once


def keep_pose(
    radius: float, angle: float, *, frame: str | None = None, base: str | None = None
) -> tuple[PositionConstraint, OrientationConstraint]:
    """Return the constraints that keep the pose of a frame at the start, in another frame or the world.

        planner.keep_pose(0.005, 0.02, frame="right_tool", base="left_tool")  # both hands carry a tray

    The frame's origin stays within ``radius`` (m), and its orientation within ``angle`` (rad). Larger tolerances let
    joints move farther between nodes, so planning is quicker.
    """
    return PositionConstraint(radius, frame=frame, base=base), OrientationConstraint(angle, frame=frame, base=base)


def is_condition(text: str) -> bool:
    """Return whether a text begins as a condition does."""
    return split_frame(text)[1].partition(":")[0] in (*_KINDS, _KEEP)


def split_frame(text: str) -> tuple[str | None, str]:
    """Return the frame that stands before a condition or a target, None without one, and the rest."""
    match = _FRAME_FIRST.match(text.strip())
    return (match[1], text.strip()[match.end() :]) if match else (None, text.strip())


def parse_conditions(text: str) -> tuple[Condition, ...]:
    """Parse a condition, of which ``keep:`` is two; :class:`OptionError` for a text of another form."""
    before, rest = split_frame(text)
    kind, _, rest = rest.partition(":")
    if kind != _KEEP:
        return (parse_condition(text),)
    radius, comma, rest = rest.partition(",")
    angle, _, frames = rest.partition(" ")
    if not comma or "," in angle:
        raise OptionError(f"condition '{text[:100]}' must be keep:radius,angle: give m and rad.")
    first = f"{before} " if before else ""
    return tuple(parse_condition(f"{first}{each} {frames}") for each in (f"near:{radius}", f"turn:{angle}"))


def parse_condition(text: str) -> Condition:
    """Parse a condition; :class:`OptionError` for a text of another form."""
    before, rest = split_frame(text)
    match, where = _SYNTAX.fullmatch(rest), f"condition '{text[:100]}'"
    if match is None or match[1] not in _KINDS:
        raise OptionError(f"condition must begin with {FORMS}, got '{text[:100]}'.")
    kind, rest, frame, base, at = match.groups()
    frame = join_frames(text, before, frame)
    cls, counts, form = _KINDS[kind]
    words = rest.split(",")
    given: dict[str, Any] = {name: each for name, each in (("frame", frame), ("base", base)) if each is not None}
    if cls is AxisConstraint:
        given["axis"] = words.pop(0).strip()
    try:
        if at is not None:
            given["point"] = tuple(map(float, at.split(",")))
        numbers = tuple(map(float, words))
    except ValueError:
        raise OptionError(f"{where} must hold numbers with commas between: correct the text.") from None
    if len(numbers) not in counts:
        raise OptionError(f"{where} must be {kind}: {form}, got {len(numbers)} numbers.")
    for name, count in cls.shape.items():
        if numbers:
            given[name], numbers = numbers[0] if count == 1 else numbers[:count], numbers[count:]
    try:
        return cls(**given)
    except OptionError as error:
        raise OptionError(f"{where} cannot be used: {error}") from None


def join_frames(text: str, before: str | None, behind: str | None) -> str | None:
    """Return the frame that stands before or behind a condition; :class:`OptionError` for two."""
    if before and behind:
        raise OptionError(f"condition '{text[:100]}' must name one frame, got '{before}' and '{behind}'.")
    return before or behind


def parse_constraints(text: str) -> tuple[Condition, ...]:
    """Parse path constraints; :class:`OptionError` for another form, or a condition that is too narrow."""
    parts = [part for part in text.split(AND) if part.strip()]
    return require_thick(tuple(each for part in parts for each in parse_conditions(part)))


def require_thick(conditions: tuple[Condition, ...]) -> tuple[Condition, ...]:
    """Return the conditions; :class:`OptionError` for one that is too narrow for any motion."""
    for condition in conditions:
        if condition.thickness < THINNEST:
            raise OptionError(
                f"constraint '{condition.text[:100]}' must leave {THINNEST:g} {condition.unit} or more, got "
                f"{condition.thickness:g}: no straight joint motion satisfies it."
            )
    return conditions


def read_conditions(value: object) -> tuple[Condition, ...]:
    """Return conditions from text, a condition, or several of both; :class:`OptionError` otherwise."""
    if isinstance(value, str):
        return parse_constraints(value)
    if isinstance(value, Condition):
        return require_thick((value,))
    if value is None:
        return ()
    if isinstance(value, Iterable):
        return tuple(each for part in value for each in read_conditions(part))
    raise OptionError(
        f"constraint must be text or conditions, got {str(value)[:100]}: give planner.AxisConstraint(...), for example."
    )


def numbers_text(values: Sequence[float]) -> str:
    """Return numbers with commas between, exact to the last bit."""
    return ",".join(repr(float(value)).removesuffix(".0") for value in values)
