"""``sweep.json``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from planner.problem.run_schema import Nodes, Record, RoadmapRecord, RunRecord

Beta = Annotated[float, Field(ge=0, le=1)]


@dataclass(frozen=True, kw_only=True, eq=False)
class IntervalRecord(Record):
    """A path and the betas that it is optimal for."""

    beta_min: Beta
    beta_max: Beta
    manipulability_cost: float
    """Omega"""
    distance_cost: float
    """D"""
    w_min: float
    w_mean: float
    joint_length: float
    """rad"""
    workspace_length: float
    """m"""
    path_nodes: Nodes
    path: list[list[float]]
    """joint waypoints, rad (m where a joint slides), start first"""


@dataclass(frozen=True, kw_only=True, eq=False)
class SweepRecord(RunRecord):
    """What ``planner sweep`` writes as sweep.json; units rad, m and s."""

    complete: bool
    intervals: list[IntervalRecord]
    """sorted; they cover [0, 1] where complete"""
    roadmap: RoadmapRecord
    solves: int
    max_error_vs_oracle: float | None
    timings_s: dict[str, float]
    files: dict[str, str] | None = None
    """SHA-256 of the files written beside this one"""
