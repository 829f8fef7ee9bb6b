"""``plan.json``."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from planner.problem.reason_schema import ReasonRecord
from planner.problem.run_schema import Nodes, RunRecord, Written


class CostRecord(Written):
    """The cost of the path: total = (1 - beta) manipulability + beta distance."""

    total: float
    manipulability: float = Field(description="Omega")
    distance: float = Field(description="D")
    beta: float = Field(ge=0, le=1)


class FloorRecord(Written):
    """What came of the manipulability floor that was asked for."""

    asked: float
    start: float = Field(description="w at the start")
    goal: float = Field(description="w at the goal")
    reached: bool
    holds: bool


class ManipulabilityRecord(Written):
    """Yoshikawa's w, sampled densely along the path."""

    min: float
    mean: float
    rows: str = Field(description="rows of the Jacobian: pose, translation or planar")
    frame: str
    floor: FloorRecord | None = None


class NearestRecord(Written):
    """The smallest distance to anything that is checked, m."""

    min: float
    pair: tuple[str, str]
    at: float = Field(description="share of the path's joint motion, or s of the motion")


class ClearanceRecord(Written):
    """How near path and motion come to anything that is checked."""

    path: NearestRecord | None = Field(description="null where there is nothing to come near to")
    motion: NearestRecord | None = Field(description="null where there is no motion")
    kept: float = Field(description="m beyond the margin that every edge kept from which the path was chosen")


class LengthRecord(Written):
    """How long the path is."""

    joint: float = Field(description="rad")
    workspace: float = Field(description="of the tool's path, m")


class CertificateRecord(Written):
    """A bound of the paper, or one of ours, beside the measured value."""

    name: str
    equation: str
    quantity: str
    bound: float
    measured: float | None
    applies: bool
    proven: bool


class FieldRecord(Written):
    """How the dynamics settled."""

    law: str
    prescribed_time: float = Field(description="T_p, s")
    settling_time: float | None = Field(description="s")
    settling_tau: float | None
    settling_tau_bracket: tuple[float | None, float | None] | None = Field(description="proved; null: not found")
    log10_remaining: float | None = Field(description="log10 of T_p minus the settling time")
    steps: int
    residual: float | None
    max_error_vs_oracle: float | None = Field(description="relative, against Dijkstra's answer")
    outcome: str
    certificate: list[CertificateRecord]


class WaypointTimesRecord(Written):
    """When each waypoint of the path is reached and left, s from the scene's time 0; what lies between is a wait."""

    arrivals: list[float]
    departures: list[float]


class HorizonRecord(Written):
    """Until when nothing can touch, whatever the obstacles with a speed limit do below it."""

    free_until: float | None = Field(description="s; null: at no time")
    speed_limits: dict[str, float] = Field(description="m/s by obstacle")


class InTimeRecord(Written):
    """How the motion keeps clear of obstacles that move."""

    moving: list[str] = Field(description="obstacles along a known motion")
    waypoints: WaypointTimesRecord | None = Field(description="null where nothing moves along a known motion")
    horizon: HorizonRecord | None = Field(description="null where no obstacle has a speed limit")


class PlanRecord(RunRecord):
    """What ``planner plan`` writes as plan.json; units rad, m and s."""

    path: list[list[float]] = Field(description="joint waypoints, rad (m where a joint slides), start first")
    path_nodes: Nodes = Field(description="their indices in the roadmap")
    goal: str | None = Field(description="which of the goals is reached")
    cost: CostRecord | None
    manipulability: ManipulabilityRecord | None
    conditioning: dict[str, Any] | None = Field(
        None, description="where w is smallest, and what to try where it is bad"
    )
    path_length: LengthRecord | None
    clearance: ClearanceRecord | None
    gabf: FieldRecord | None
    in_time: InTimeRecord | None = Field(None, description="null where no obstacle moves or may move, or no motion is")
    reason: ReasonRecord | None = Field(None, description="why there is no path")
