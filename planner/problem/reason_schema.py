"""``reason`` in ``plan.json``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from planner.problem.run_schema import Record

_Names = Annotated[list[str], Field(min_length=1)]


@dataclass(frozen=True, kw_only=True, eq=False)
class GapRecord(Record):
    """How near the parts of the roadmap that hold start and goal came: the shortest straight motion between them."""

    joint_distance: float
    """rad"""
    start_side: list[float]
    """its configuration on the start's side"""
    goal_side: list[float]
    """its configuration on the goal's side"""
    between: tuple[str, str] | None
    """the two things that come too near along it"""


@dataclass(frozen=True, kw_only=True, eq=False)
class SeparatedRecord(Record):
    """Obstacles without which start and goal are joined; no smaller set was found, which does not exclude one."""

    kind: Literal["separated"]
    obstacles: _Names
    gap: GapRecord


@dataclass(frozen=True, kw_only=True, eq=False)
class BudgetSpentRecord(Record):
    """Start and goal were not joined, and no obstacle was found that separates them."""

    kind: Literal["budget_spent"]
    nodes: int
    """in the roadmap"""
    gap: GapRecord


@dataclass(frozen=True, kw_only=True, eq=False)
class FloorTooHighRecord(Record):
    """No path keeps to the manipulability floor."""

    kind: Literal["floor_too_high"]
    asked: float
    reachable: float
    """the highest floor found that a path keeps to; 0: all pass through w = 0 or near it"""


@dataclass(frozen=True, kw_only=True, eq=False)
class KeptTooNarrowRecord(Record):
    """Start and goal are joined, but not by a path that keeps what is to be kept."""

    kind: Literal["kept_too_narrow"]
    conditions: _Names
    """as --keep takes them"""
    gap: GapRecord


@dataclass(frozen=True, kw_only=True, eq=False)
class BlockedInTimeRecord(Record):
    """Start and goal are joined, but no motion in time keeps clear of what moves along known motions."""

    kind: Literal["blocked_in_time"]
    place: Literal["start", "goal", "route"]
    """start: not clear at time 0; goal: it cannot be stayed at; route: no motion leads past"""
    obstacles: _Names


@dataclass(frozen=True, kw_only=True, eq=False)
class DeviationRecord(Record):
    """How far the tool is off its path, or may be."""

    position: float
    """m"""
    angle: float
    """rad, of its orientation, or of its z axis where it may turn about that; beyond a cone where one is given"""

    def or_more(self, other: DeviationRecord) -> DeviationRecord:
        """The larger of both, each by itself."""
        return DeviationRecord(position=max(self.position, other.position), angle=max(self.angle, other.angle))


NO_DEVIATION = DeviationRecord(position=0.0, angle=0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class CannotFollowRecord(Record):
    """A tool path cannot be followed to one of its points."""

    kind: Literal["cannot_follow"]
    point: int
    """of the file, from 1"""
    followed: float
    """share of the path's length"""
    cause: Literal["out_of_reach", "turned", "beyond_limit", "touching", "strays", "below_floor", "jump"]
    distance: float
    """m, for turned and jump rad, for strays as what is kept"""
    between: list[str]
    """the two things that touch, joints whose limits would have to be left, or the condition that would be broken"""
    reachable: float
    """the highest floor found with which it goes on, where the floor is too high"""
    cone: float | None
    """rad: the narrowest about the tool's axis with which it was found to go on; 0: a free turn about it will do"""
    leg: Literal["", "approach", "retreat"]
    """which leg of a plan it is, point 1 the plan's goal or start"""


ReasonRecord = Annotated[
    SeparatedRecord
    | BudgetSpentRecord
    | FloorTooHighRecord
    | KeptTooNarrowRecord
    | BlockedInTimeRecord
    | CannotFollowRecord,
    Field(discriminator="kind"),
]
