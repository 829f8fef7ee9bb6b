"""``sweep.json``."""

from __future__ import annotations

from pydantic import Field

from planner.problem.run_schema import Nodes, RunRecord, Written


class IntervalRecord(Written):
    """A path and the betas that it is optimal for."""

    beta_min: float = Field(ge=0, le=1)
    beta_max: float = Field(ge=0, le=1)
    manipulability_cost: float = Field(description="Omega")
    distance_cost: float = Field(description="D")
    w_min: float
    w_mean: float
    joint_length: float = Field(description="rad")
    workspace_length: float = Field(description="m")
    path_nodes: Nodes
    path: list[list[float]] = Field(description="joint waypoints, rad (m where a joint slides), start first")


class PointRecord(Written):
    """A non-dominated path."""

    manipulability_cost: float
    distance_cost: float
    optimal_at_some_beta: bool
    path_nodes: Nodes


class FrontRecord(Written):
    """The non-dominated paths."""

    complete: bool
    labels: int = Field(description="partial paths that the search made")
    beyond_every_beta: int
    points: list[PointRecord]


class SupportRecord(Written):
    """A path that is optimal at a beta."""

    beta: float = Field(ge=0, le=1)
    path_nodes: Nodes


class SearchRecord(Written):
    """What --resume goes on from."""

    roadmap_whole: bool
    settled: int
    barred: list[tuple[int, int]]
    found: list[SupportRecord]


class SweepRecord(RunRecord):
    """What ``planner sweep`` writes as sweep.json; units rad, m and s."""

    complete: bool
    intervals: list[IntervalRecord] = Field(description="sorted; they cover [0, 1] where complete")
    front: FrontRecord | None
    solves: int
    max_error_vs_oracle: float | None
    search: SearchRecord
