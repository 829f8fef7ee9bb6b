"""The outcome of a run, the reasons as data and as sentences, and the base class of records."""

from collections.abc import Iterable, Sequence
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from enum import Enum
from html import escape
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from planner.base.errors import FileError, Reason, choices
from planner.problem.conditions import parse_condition

FORMAT_VERSION = 1  # of plan.json and sweep.json; raised when a key goes or changes its meaning
Nodes = list[Annotated[int, Field(ge=0)]]
Rows = list[tuple[str, str]]
"""The rows of a table: names and texts."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """Base of all records: a file holds the fields, and their docstrings are the schema of the file.

    A file leaves out fields with their default. Unknown keys of a file are ignored.
    """

    __pydantic_config__: ClassVar = {"extra": "allow", "allow_inf_nan": False, "use_attribute_docstrings": True}

    def to_dict(self) -> dict[str, Any]:
        """Return the fields in their order, as plain data."""
        written = {field.name: (getattr(self, field.name), field.default) for field in fields(self)}
        return {
            name: _plain(value)
            for name, (value, default) in written.items()
            if default is MISSING or value is not default
        }


def _plain(value: Any) -> Any:
    if isinstance(value, Record):
        return value.to_dict()
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value


class Outcome(Enum):
    """The outcome of a run; wrong input raises a :class:`~planner.base.errors.PlannerError` instead.

    ``plan.json`` holds ``name.lower()``; the value is the sentence with the remedy.
    """

    SOLVED = "A collision-free path was found."
    NO_PATH = (
        "Start and goal were not connected within the budget: raise --nodes, try another --seed, "
        "or look at the roadmap in the page to see where it stops."
    )
    TOO_SINGULAR = (
        "No path above the manipulability floor was found within the budget: lower --min-manipulability, "
        "raise --nodes, or try another --seed."
    )
    PARTLY_FOLLOWED = (
        "The tool path could be followed in part only: move it, widen its tube, or let the tool turn about its axis."
    )
    INTERRUPTED = "Interrupted: the result is partial."

    @property
    def key(self) -> str:
        return self.name.lower()

    @property
    def exit_code(self) -> int:
        """The exit code of a command with this outcome."""
        return {Outcome.SOLVED: 0, Outcome.INTERRUPTED: 130}.get(self, 4)


def require_readable_version(record: dict[str, Any], where: str) -> None:
    """Raise :class:`FileError` for a record of a later format; version 1 if it has none."""
    version = record.get("format_version", 1)
    if not (isinstance(version, int) and 1 <= version <= FORMAT_VERSION):
        raise FileError(
            f"format version of {where} must be 1 to {FORMAT_VERSION}, got {version!r:.40}: update the planner, or "
            "make the file again with this one."
        )


def html_table(caption: str, rows: Sequence[Sequence[str]], head: Sequence[str] = ()) -> str:
    """Return an HTML table for a notebook, with all text escaped."""
    top = f"<thead>{_html_row('th', head)}</thead>" if head else ""
    body = "".join(_html_row("td", row) for row in rows)
    return f"<p>{escape(caption)}</p><table>{top}<tbody>{body}</tbody></table>"


def _html_row(tag: str, cells: Sequence[str]) -> str:
    return "<tr>" + "".join(f'<{tag} style="text-align:left">{escape(cell)}</{tag}>' for cell in cells) + "</tr>"


_Names = Annotated[tuple[str, ...], Field(min_length=1)]


def _quote(names: Iterable[str]) -> str:
    return choices(f"'{name}'" for name in names)


@dataclass(frozen=True)
class Touching(Reason):
    """Two bodies touch, or are closer than the margin, at ``role``: "start", "goal" or "world".

    ``enclosed``: one lies inside the other.
    """

    kind: Literal["touching"] = field(default="touching", kw_only=True)
    role: str
    first: str
    second: str
    enclosed: bool

    @property
    def names(self) -> frozenset[str]:
        return frozenset((self.first, self.second))


@dataclass(frozen=True)
class BeyondLimit(Reason):
    """``role`` has a joint at ``value``, outside [``lower``, ``upper``] (rad, or m for a slide)."""

    kind: Literal["beyond_limit"] = field(default="beyond_limit", kw_only=True)
    role: str
    joint: str
    value: float
    lower: float
    upper: float


@dataclass(frozen=True)
class ConstraintBroken(Reason):
    """``role`` breaks a path constraint, given as text, ``by`` an amount (rad or m)."""

    kind: Literal["constraint_broken"] = field(default="constraint_broken", kw_only=True)
    role: str
    condition: str
    by: float


@dataclass(frozen=True)
class OutOfReach(Reason):
    """No configuration brings the tool to ``role``; the nearest one stays ``distance`` (m) away."""

    kind: Literal["out_of_reach"] = field(default="out_of_reach", kw_only=True)
    role: str
    distance: float


@dataclass(frozen=True)
class Gap(Record):
    """The shortest straight motion between the components of the start and the goal."""

    joint_distance: float
    """rad"""
    start_side: tuple[float, ...]
    """its end in the component of the start"""
    goal_side: tuple[float, ...]
    """its end in the component of the goal"""
    between: tuple[str, str] | None
    """the two bodies that come too near along it; null if none was found"""

    @property
    def sentence(self) -> str:
        stop = f", where '{self.between[0]}' and '{self.between[1]}' come too near" if self.between else ""
        return f"their components of the roadmap came within {self.joint_distance:.3g} rad of each other{stop}"


@dataclass(frozen=True)
class Separated(Reason):
    """Obstacles without which start and goal are connected; a smaller set may exist."""

    kind: Literal["separated"] = field(default="separated", kw_only=True)
    obstacles: _Names
    gap: Gap

    @property
    def sentence(self) -> str:
        one = len(self.obstacles) == 1
        return (
            f"Start and goal were not connected within the budget: the search found that {_quote(self.obstacles)} "
            f"{'separates' if one else 'together separate'} them (without {'it' if one else 'them'} they connect), "
            f"and {self.gap.sentence}: move {'it' if one else 'one of them'}, raise --nodes, or try another --seed."
        )


@dataclass(frozen=True)
class BudgetSpent(Reason):
    """The search did not connect start and goal, and no obstacle was found that separates them."""

    kind: Literal["budget_spent"] = field(default="budget_spent", kw_only=True)
    nodes: int
    """in the roadmap"""
    gap: Gap

    @property
    def names(self) -> frozenset[str]:
        return frozenset(self.gap.between or ())

    @property
    def sentence(self) -> str:
        return (
            f"Start and goal were not connected within the budget of {self.nodes} nodes: {self.gap.sentence}; no "
            "obstacle was found without which they are connected: raise --nodes, or try another --seed."
        )


@dataclass(frozen=True)
class FloorTooHigh(Reason):
    """No path stays above the manipulability floor."""

    kind: Literal["floor_too_high"] = field(default="floor_too_high", kw_only=True)
    asked: float
    reachable: float
    """the highest floor found with a path above it; 0: all pass near w = 0"""

    @property
    def sentence(self) -> str:
        why = "all known paths pass near w = 0: leave out --min-manipulability."
        if self.reachable > 0:
            why = f"the highest floor with a path is {self.reachable:g}: take --min-manipulability "
            why += f"{self.reachable:g} or less, raise --nodes, or try another --seed."
        return f"No path above the manipulability floor of {self.asked:g} was found within the budget: {why}"


@dataclass(frozen=True)
class ConstraintsTooNarrow(Reason):
    """Start and goal are connected, but not by a path within the constraints."""

    kind: Literal["constraints_too_narrow"] = field(default="constraints_too_narrow", kw_only=True)
    conditions: _Names
    """as --constraint takes them"""
    gap: Gap

    @property
    def sentence(self) -> str:
        return (
            f"No path within {_quote(self.conditions)} was found within the budget; without the constraint start and "
            f"goal are connected, and with it {self.gap.sentence}: leave more tolerance, raise --nodes, or try another "
            "--seed."
        )


@dataclass(frozen=True)
class BlockedInTime(Reason):
    """Start and goal are connected, but no motion in time avoids the moving obstacles."""

    kind: Literal["blocked_in_time"] = field(default="blocked_in_time", kw_only=True)
    place: Literal["start", "goal", "route"]
    """start: not clear at time 0; goal: not clear later; route: no motion leads past"""
    obstacles: _Names

    @property
    def sentence(self) -> str:
        named = _quote(self.obstacles)
        why = {
            "start": f"at time 0 {named} cannot be proven clear of the arm at the start: choose another start.",
            "goal": f"the arm cannot stay at the goal, as {named} comes too near: choose another goal.",
            "route": f"no motion through the roadmap avoids {named}, also with waiting: "
            "raise --nodes, or try another --seed.",
        }
        return f"Start and goal are connected, but not in time: {why[self.place]}"


@dataclass(frozen=True)
class CannotFollow(Reason):
    """A tool path cannot be followed to one of its points."""

    kind: Literal["cannot_follow"] = field(default="cannot_follow", kw_only=True)
    point: int
    """of the file, from 1"""
    followed: float
    """share of the path's length"""
    cause: Literal["out_of_reach", "turned", "beyond_limit", "touching", "strays", "below_floor", "jump"]
    """jump: all solutions of this point are on other branches"""
    distance: float = 0.0
    """m by which the tool misses the point; rad for turned and jump; for strays the unit of the constraint"""
    between: tuple[str, ...] = ()
    """the two bodies that touch, the joints whose limits are exceeded, or the broken constraint"""
    reachable: float = 0.0
    """the highest floor with a path, if the floor is too high"""
    leg: Literal["", "approach", "retreat"] = ""
    """the leg of a plan; point 1 is then the plan's goal or start"""
    cone: float | None = None
    """rad: the narrowest cone about the tool's axis with a path; 0: a free turn about it suffices"""

    @property
    def names(self) -> frozenset[str]:
        return frozenset(self.between if self.cause == "touching" else ())

    @property
    def sentence(self) -> str:
        head = f"The tool path can be followed over {100 * self.followed:.1f} %, not to point {self.point}: "
        if self.leg:
            head = f"The {self.leg} is possible over {100 * self.followed:.1f} % of its length, from its end: "
        return f"{head}{self._cause}."

    @property
    def _cause(self) -> str:
        """The cause and a remedy."""
        remedy, pair = "move the path or the robot's base", " and ".join(f"'{name}'" for name in self.between)
        if self.cone is not None:
            remedy = f"give a cone of {self.cone:g} rad about its axis" if self.cone else "let it turn about its axis"
        if self.leg:
            remedy = f"shorten it, or choose another {'goal' if self.leg == 'approach' else 'start'}"
        far, unit = f"{self.distance:.3g}", parse_condition(self.between[0]).unit if self.cause == "strays" else ""
        return {
            "out_of_reach": f"the tool stays {far} m away; {remedy}",
            "turned": f"the tool stays turned away by {far} rad; {remedy}",
            "beyond_limit": f"the arm would exceed the limits of {choices(self.between)}; {remedy}",
            "touching": f"{pair} come too near in all solutions found; move the path or what is near",
            "strays": f"the constraint {pair} would be broken by {far} {unit}; move the path, or relax the constraint",
            "below_floor": f"the floor is too high; take the highest possible one, {self.reachable:g}",
            "jump": f"the next solutions are {far} rad away, on other branches or behind an obstacle; free the tool's "
            "axis, widen the tube, or split the path there",
        }[self.cause]


NoWay = Separated | BudgetSpent | ConstraintsTooNarrow
"""Start and goal lie in different components of the roadmap."""

NoPath = NoWay | FloorTooHigh | BlockedInTime | CannotFollow
