"""``reason`` in ``plan.json``."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from planner.problem.run_schema import Written


class GapRecord(Written):
    """How near the parts of the roadmap that hold start and goal came: the shortest straight motion between them."""

    joint_distance: float = Field(description="rad")
    start_side: list[float] = Field(description="its configuration on the start's side")
    goal_side: list[float] = Field(description="its configuration on the goal's side")
    between: tuple[str, str] | None = Field(description="the two things that come too near along it")


class SeparatedRecord(Written):
    """Obstacles without which start and goal are joined; no smaller set was found, which does not exclude one."""

    kind: Literal["separated"]
    obstacles: list[str] = Field(min_length=1)
    gap: GapRecord


class BudgetSpentRecord(Written):
    """Start and goal were not joined, and no obstacle was found that separates them."""

    kind: Literal["budget_spent"]
    nodes: int = Field(description="in the roadmap")
    gap: GapRecord


class FloorTooHighRecord(Written):
    """No path keeps to the manipulability floor."""

    kind: Literal["floor_too_high"]
    asked: float
    reachable: float = Field(description="the highest floor found that a path keeps to; 0: all pass through w = 0")


class BlockedInTimeRecord(Written):
    """Start and goal are joined, but no motion in time keeps clear of what moves along known motions."""

    kind: Literal["blocked_in_time"]
    place: Literal["start", "goal", "route"] = Field(
        description="start: not clear at time 0; goal: it cannot be stayed at; route: no motion leads past"
    )
    obstacles: list[str] = Field(min_length=1)


ReasonRecord = Annotated[
    SeparatedRecord | BudgetSpentRecord | FloorTooHighRecord | BlockedInTimeRecord, Field(discriminator="kind")
]
