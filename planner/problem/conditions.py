"""Conditions on a frame of the arm, as people write them: what a motion keeps all along, or a goal asks of its end.

``axis:z,0,0,1,0.1`` (the tool's z axis within 0.1 rad of a direction of the world), ``box:x0,y0,z0,x1,y1,z1`` (its
origin within, m), ``plane:nx,ny,nz,d`` (n.p >= d) and ``turn:0.1`` (its orientation within 0.1 rad of that at the
start, or of a quaternion: ``turn:0.1,qx,qy,qz,qw``). `` of FRAME`` at the end names another frame than the tool, and
`` at x,y,z`` after it a point of that frame. Several are written with ``;`` between.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from planner.base.errors import OptionError, choices

_FARTHEST = 1e4  # rad (m): what is written beyond is no condition on an arm
THINNEST = 1e-4  # rad (m): no straight joint motion of any length keeps to less
_AXES = ("x", "y", "z")
_TURNS = 2.0 * math.pi * (1.0 + 1e-4)  # rad: a tolerance of more is taken for degrees
_UNIT = 1e-3  # by how much a quaternion's length may differ from 1
_LENGTHS = {"quaternion": 4}  # of fields with several numbers; 3 of all others
_OPTIONAL = ("quaternion", "angle")  # at the end
_SYNTAX = re.compile(r"(\w+):(.*?)(?:\s+of\s+(\S+))?(?:\s+at\s+(\S+))?")
FORMS = "axis:, box:, plane: or turn:"
AND = ";"  # between conditions

Three = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class Condition:
    """On one ``frame`` of the robot, the tool where None.

    ``shape``: the fields of its numbers in the order of its text, and how many each takes.
    """

    frame: str | None = None
    kind: ClassVar[str]
    unit: ClassVar[str] = "rad"
    shape: ClassVar[Mapping[str, int]]

    def __post_init__(self) -> None:
        for name, value in list(vars(self).items()):
            if value is None or isinstance(value, str | float | int):
                continue
            try:
                numbers = tuple(float(number) for number in value)
            except (TypeError, ValueError):
                raise OptionError(f"a condition's {name} holds something that is no number: give numbers.") from None
            if len(numbers) != (wanted := _LENGTHS.get(name, 3)):
                raise OptionError(f"a condition's {name} has {len(numbers)} numbers: give {wanted}.")
            object.__setattr__(self, name, numbers)
        numbers = (*self.values, *getattr(self, "point", ()))
        if not all(map(math.isfinite, numbers)):
            raise self._unusable("it holds what is no finite number: give plain numbers")
        if max(map(abs, numbers)) > _FARTHEST:
            raise self._unusable(f"it holds a value beyond {_FARTHEST:g}: give rad and metres")
        angle = getattr(self, "angle", 0.0)
        if angle < 0:
            raise self._unusable("its angle is negative: give 0 or more")
        if angle > _TURNS:
            raise self._unusable(f"{angle:g} rad is more than a turn: degrees? 5 degrees are 0.0873")
        if any(not math.hypot(*getattr(self, name)) > 1e-9 for name in ("direction", "normal") if hasattr(self, name)):
            raise self._unusable("its direction has no length: give one such as 0,0,1")

    @property
    def values(self) -> tuple[float, ...]:
        """Its numbers in the order of its text."""
        said = (getattr(self, name) for name in self.shape)
        return tuple(number for each in said if each is not None for number in _tuple(each))

    @property
    def thickness(self) -> float:
        """How far (rad, m) it is from one side of what it allows to the other; inf where that has no end."""
        return getattr(self, "angle", math.inf)

    @property
    def text(self) -> str:
        """As people write it, exact to the last bit."""
        axis = f"{self.axis}," if isinstance(self, KeepAxis) else ""
        return f"{self.kind}:{axis}{numbers_text(self.values)}{f' of {self.frame}' if self.frame else ''}"

    def _unusable(self, why: str) -> OptionError:
        return OptionError(f"'{self.text[:100]}' is not usable: {why}.")


@dataclass(frozen=True, kw_only=True, eq=False)
class OfPoint(Condition):
    """On the ``point`` (m) of a frame, its origin where left out."""

    point: Three = (0.0, 0.0, 0.0)
    unit: ClassVar[str] = "m"

    @property
    def text(self) -> str:
        return super().text + (f" at {numbers_text(self.point)}" if any(self.point) else "")


@dataclass(frozen=True)
class KeepAxis(Condition):
    """A frame's ``axis``, x, y or z, within ``angle`` (rad) of a ``direction`` of the world; it may turn about it."""

    axis: str
    direction: Three
    angle: float = 0.0
    kind = "axis"
    shape = {"direction": 3, "angle": 1}  # noqa: RUF012 (a ClassVar by its base)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.axis not in _AXES:
            raise self._unusable(f"axis '{self.axis[:20]}' is none of {choices(_AXES)}")
        if self.angle > math.pi:
            raise self._unusable("no two directions are further apart than 3.1416 rad")


@dataclass(frozen=True)
class KeepBox(OfPoint):
    """A frame's origin, or ``point``, between ``lower`` and ``upper`` (m)."""

    lower: Three
    upper: Three
    kind = "box"
    shape = {"lower": 3, "upper": 3}  # noqa: RUF012

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.thickness < 0:
            raise self._unusable("a lower corner lies above an upper one: give x0,y0,z0,x1,y1,z1")

    @property
    def thickness(self) -> float:
        return min(high - low for low, high in zip(self.lower, self.upper, strict=True))


@dataclass(frozen=True)
class KeepPlane(OfPoint):
    """A frame's origin, or ``point``, p on one side of a plane: ``normal`` . p >= ``distance`` (m)."""

    normal: Three
    distance: float
    kind = "plane"
    shape = {"normal": 3, "distance": 1}  # noqa: RUF012


@dataclass(frozen=True)
class KeepTurn(Condition):
    """A frame's orientation within ``angle`` (rad) of ``quaternion`` (x, y, z, w), or of that at the start."""

    angle: float
    quaternion: Quaternion | None = None
    kind = "turn"
    shape = {"angle": 1, "quaternion": 4}  # noqa: RUF012

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.quaternion is not None and abs(math.hypot(*self.quaternion) - 1.0) > _UNIT:
            raise self._unusable("its quaternion is not of length 1: give qx,qy,qz,qw")


_KINDS: dict[str, tuple[type[Condition], str]] = {
    "axis": (KeepAxis, "x, y or z, then nx,ny,nz,angle"),
    "box": (KeepBox, "x0,y0,z0,x1,y1,z1"),
    "plane": (KeepPlane, "nx,ny,nz,d"),
    "turn": (KeepTurn, "angle or angle,qx,qy,qz,qw"),
}


def is_condition(text: str) -> bool:
    """Whether a text begins as a condition does."""
    return text.strip().partition(":")[0] in _KINDS


def parse_condition(text: str) -> Condition:
    """A condition out of its text; :class:`OptionError` where the text has no meaning."""
    found = _SYNTAX.fullmatch(text.strip())
    if found is None or found[1] not in _KINDS:
        raise OptionError(f"condition '{text[:100]}' is not usable: give {FORMS}.")
    kind, rest, frame, at = found.groups()
    made, form = _KINDS[kind]
    words = rest.split(",")
    given: dict[str, Any] = {} if frame is None else {"frame": frame}
    if made is KeepAxis:
        given["axis"] = words.pop(0).strip()
    if at is not None and not issubclass(made, OfPoint):
        raise OptionError(f"condition '{text[:100]}' is not usable: ' at x,y,z' goes with box and plane.")
    if at is not None:
        given["point"] = _numbers(text, at.split(","))
    values, ends = _numbers(text, words), list(itertools.accumulate(made.shape.values()))
    if len(values) not in ends[-2 if [*made.shape][-1] in _OPTIONAL else -1 :]:
        raise OptionError(f"condition '{text[:100]}' has {len(values)} numbers: give {kind}: {form}.")
    for (name, count), end in zip(made.shape.items(), ends, strict=True):
        if end <= len(values):
            given[name] = values[end - 1] if count == 1 else values[end - count : end]
    return made(**given)


def parse_keeps(text: str) -> tuple[Condition, ...]:
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


def conditions_of(value: object) -> tuple[Condition, ...]:
    """Conditions out of text, a condition, or several of both; :class:`OptionError` for anything else."""
    if isinstance(value, str):
        return parse_keeps(value)
    if isinstance(value, Condition):
        return parse_keeps(value.text)
    if value is None:
        return ()
    if isinstance(value, Iterable):
        return tuple(each for part in value for each in conditions_of(part))
    raise OptionError(f"keep must be conditions, got {str(value)[:100]}: give text or planner.KeepAxis and its like.")


def numbers_text(values: Sequence[float]) -> str:
    """Numbers with commas between, exact to the last bit."""
    return ",".join(repr(float(value)).removesuffix(".0") for value in values)


def _numbers(text: str, words: Sequence[str]) -> tuple[float, ...]:
    try:
        return tuple(float(word) for word in words)
    except ValueError:
        raise OptionError(
            f"condition '{text[:100]}' holds something that is no number: give numbers with commas between."
        ) from None


def _tuple(value: float | tuple[float, ...]) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,)
