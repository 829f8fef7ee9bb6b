"""Conditions on a frame of the arm, as people write them: what a motion keeps all along, or a goal asks of its end.

``axis:z,0,0,1,0.1`` (the tool's z axis within 0.1 rad of a direction of the world), ``box:x0,y0,z0,x1,y1,z1`` (its
origin within, m), ``plane:nx,ny,nz,d`` (n.p >= d) and ``turn:0.1`` (its orientation within 0.1 rad of that at the
start, or of a quaternion: ``turn:0.1,qx,qy,qz,qw``). `` of FRAME`` at the end names another frame than the tool, and
`` at x,y,z`` after it a point of that frame. Several are written with ``;`` between.
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

THINNEST = 1e-4  # rad (m): no straight joint motion of any length keeps to less
FORMS = "axis:, box:, plane: or turn:"
AND = ";"  # between conditions
_TURNS = 2.0 * math.pi * (1.0 + 1e-4)  # rad: a tolerance of more is taken for degrees
_UNIT = 1e-3  # by how much a quaternion's length may differ from 1
_SYNTAX = re.compile(r"(\w+):(.*?)(?:\s+of\s+(\S+))?(?:\s+at\s+(\S+))?")


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
    """On one ``frame`` of the robot, the tool where None.

    ``shape``: the fields of its numbers in the order of its text, and how many each takes.
    """

    frame: str | None = field(default=None, kw_only=True)
    kind: ClassVar[str]
    unit: ClassVar[str] = "rad"
    shape: ClassVar[Mapping[str, int]]

    @property
    def values(self) -> tuple[float, ...]:
        """Its numbers in the order of its text."""
        values = [getattr(self, name) for name in self.shape]
        return tuple(np.hstack([each for each in values if each is not None]).tolist())

    @property
    def thickness(self) -> float:
        """How far (rad, m) it is from one side of what it allows to the other; inf where that has no end."""
        return getattr(self, "angle", math.inf)

    @property
    def text(self) -> str:
        """As people write it, exact to the last bit."""
        axis = f"{self.axis}," if isinstance(self, AxisConstraint) else ""
        return f"{self.kind}:{axis}{numbers_text(self.values)}{f' of {self.frame}' if self.frame else ''}"


@options
class OfPoint(Condition):
    """On the ``point`` (m) of a frame, its origin where left out."""

    point: Three = field(default=(0.0, 0.0, 0.0), kw_only=True)
    unit: ClassVar[str] = "m"

    @property
    def text(self) -> str:
        return super().text + (f" at {numbers_text(self.point)}" if any(self.point) else "")


@options
class AxisConstraint(Condition):
    """A frame's ``axis``, x, y or z, within ``angle`` (rad) of a ``direction`` of the world; it may turn about it."""

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
            raise OptionError("a box's lower corner must lie below its upper one: give x0,y0,z0,x1,y1,z1.")

    @property
    def thickness(self) -> float:
        return min(high - low for low, high in zip(self.lower, self.upper, strict=True))


@options
class PlaneConstraint(OfPoint):
    """A frame's origin, or ``point``, p on one side of a plane: ``normal`` . p >= ``distance`` (m)."""

    normal: Direction
    distance: Number
    kind: ClassVar[str] = "plane"
    shape: ClassVar[Mapping[str, int]] = {"normal": 3, "distance": 1}


@options
class OrientationConstraint(Condition):
    """A frame's orientation within ``angle`` (rad) of ``quaternion`` (x, y, z, w), or of that at the start."""

    angle: Angle
    quaternion: Annotated[Quaternion, BeforeValidator(tuple), AfterValidator(_unit)] | None = None
    kind: ClassVar[str] = "turn"
    shape: ClassVar[Mapping[str, int]] = {"angle": 1, "quaternion": 4}


# of each: its class, how many numbers it takes, and how they are written
_KINDS: dict[str, tuple[type[Condition], tuple[int, ...], str]] = {
    "axis": (AxisConstraint, (3, 4), "x, y or z, then nx,ny,nz,angle"),
    "box": (BoxConstraint, (6,), "x0,y0,z0,x1,y1,z1"),
    "plane": (PlaneConstraint, (4,), "nx,ny,nz,d"),
    "turn": (OrientationConstraint, (1, 5), "angle or angle,qx,qy,qz,qw"),
}


def is_condition(text: str) -> bool:
    """Whether a text begins as a condition does."""
    return text.strip().partition(":")[0] in _KINDS


def parse_condition(text: str) -> Condition:
    """A condition out of its text; :class:`OptionError` where the text has no meaning."""
    found, where = _SYNTAX.fullmatch(text.strip()), f"condition '{text[:100]}'"
    if found is None or found[1] not in _KINDS:
        raise OptionError(f"{where} is not usable: give {FORMS}.")
    kind, rest, frame, at = found.groups()
    made, counts, form = _KINDS[kind]
    words = rest.split(",")
    given: dict[str, Any] = {} if frame is None else {"frame": frame}
    if made is AxisConstraint:
        given["axis"] = words.pop(0).strip()
    try:
        if at is not None:
            given["point"] = tuple(map(float, at.split(",")))
        numbers = tuple(map(float, words))
    except ValueError:
        raise OptionError(f"{where} holds a word that is no number: give numbers with commas between.") from None
    if len(numbers) not in counts:
        raise OptionError(f"{where} has {len(numbers)} numbers: give {kind}: {form}.")
    for name, count in made.shape.items():
        if numbers:
            given[name], numbers = numbers[0] if count == 1 else numbers[:count], numbers[count:]
    try:
        return made(**given)
    except OptionError as error:
        raise OptionError(f"{where} is not usable: {error}") from None


def parse_constraints(text: str) -> tuple[Condition, ...]:
    """What a motion is to keep out of its text; :class:`OptionError` where it has no meaning, or is too thin."""
    return require_thick(tuple(parse_condition(part) for part in text.split(AND) if part.strip()))


def require_thick(conditions: tuple[Condition, ...]) -> tuple[Condition, ...]:
    """The conditions; :class:`OptionError` for one that leaves so little that no motion keeps it."""
    for condition in conditions:
        if condition.thickness < THINNEST:
            raise OptionError(
                f"'{condition.text[:100]}' leaves {condition.thickness:g} {condition.unit} and no motion straight in "
                f"joints keeps to that: leave {THINNEST:g} or more."
            )
    return conditions


def read_conditions(value: object) -> tuple[Condition, ...]:
    """Conditions out of text, a condition, or several of both; :class:`OptionError` for anything else."""
    if isinstance(value, str):
        return parse_constraints(value)
    if isinstance(value, Condition):
        return require_thick((value,))
    if value is None:
        return ()
    if isinstance(value, Iterable):
        return tuple(each for part in value for each in read_conditions(part))
    raise OptionError(
        f"constraint must be conditions, got {str(value)[:100]}: give text or planner.AxisConstraint and its like."
    )


def numbers_text(values: Sequence[float]) -> str:
    """Numbers with commas between, exact to the last bit."""
    return ",".join(repr(float(value)).removesuffix(".0") for value in values)
