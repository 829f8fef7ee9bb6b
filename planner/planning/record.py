"""``plan.json``: the record that is written, whose types and docstrings are the schema of the file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from planner.planning.run_record import RunRecord
from planner.problem.reasons import NoPath
from planner.problem.run_schema import Nodes, Record
from planner.roadmap.record_text import RoadmapRecord
from planner.search.network import PathCost
from planner.tool_paths.timing import ToolSpeedRecord
from planner.tool_paths.tool_path import TubeSize
from planner.tool_paths.tube import Deviation
from planner.trajectory.clearance import Nearest


@dataclass(frozen=True, kw_only=True, eq=False)
class PointRecord(Record):
    """The best cost after so many rounds."""

    rounds: int
    cost: float


@dataclass(frozen=True, kw_only=True, eq=False)
class QualityRecord(Record):
    """How good the path is."""

    effort: int
    """rounds of refinement and search"""
    curve: list[PointRecord]
    lower_bound: float
    """no path between the roadmap's start and goal configurations costs less"""
    gap: float | None
    """how much more this one costs at most than the optimum between these, as a share"""
    manipulability_cost: float | None
    """Omega of the path in pieces of 0.01 rad, where ``cost`` has it by few states an edge; None if charged at nodes"""
    corners: int


@dataclass(frozen=True, kw_only=True, eq=False)
class FloorRecord(Record):
    """What came of the manipulability floor that was asked for."""

    asked: float
    start: float
    """w at the start"""
    goal: float
    """w at the goal"""
    reached: bool
    holds: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class ManipulabilityRecord(Record):
    """Yoshikawa's w, sampled densely along the path."""

    min: float
    mean: float
    rows: str
    """rows of the Jacobian: pose, translation or planar"""
    frame: str
    floor: FloorRecord | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class ClearanceRecord(Record):
    """How near path and motion come to anything that is checked."""

    path: Nearest | None
    """null where there is nothing to come near to"""
    motion: Nearest | None
    """null where there is no motion"""
    kept: float
    """m beyond the margin that every edge kept from which the path was chosen"""


@dataclass(frozen=True, kw_only=True, eq=False)
class LengthRecord(Record):
    """How long the path is."""

    joint: float
    """rad"""
    workspace: float
    """of the tool's path, m"""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionRecord(Record):
    """The trajectory beside it."""

    law: str
    duration: float
    """s"""
    limits: str
    corners: int | None = None
    corners_blended: int | None = None
    shortcuts: int | None = None
    proven: bool
    floor: dict[str, Any] | None


@dataclass(frozen=True, kw_only=True, eq=False)
class KeptRecord(Record):
    """What came of a condition that is kept all along."""

    condition: str
    """as --keep takes it"""
    unit: str
    """of the least it has to spare, negative where it is broken"""
    path: float
    """least to spare along the path, sampled densely"""
    path_proven: bool
    motion: float | None
    """and in motion; null where there is none"""
    motion_proven: bool | None


@dataclass(frozen=True, kw_only=True, eq=False)
class CertificateRecord(Record):
    """A bound of the paper, or one of ours, beside the measured value; null where a number overflows."""

    name: str
    equation: str
    quantity: str
    bound: float | None
    measured: float | None
    slack: float | None
    assumptions: list[dict[str, Any]]
    ours: bool
    log10_remaining: float | None
    proven: bool
    earliest: float | None
    latest: float | None
    applies: bool
    holds: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldRecord(Record):
    """How the dynamics settled."""

    law: str
    prescribed_time: float
    """T_p, s"""
    settling_time: float | None
    """s"""
    settling_tau: float | None
    settling_tau_bracket: list[float | None] | None
    """proved: earliest and latest, null where it was not found; 0 and null for a field too large to be enclosed"""
    log10_remaining: float | None
    """log10 of T_p minus the settling time"""
    steps: int
    residual: float | None
    max_error_vs_oracle: float | None
    """relative, against Dijkstra's answer"""
    outcome: str
    certificate: list[CertificateRecord]


@dataclass(frozen=True, kw_only=True, eq=False)
class WaypointTimesRecord(Record):
    """When each waypoint of the path is reached and left, s from the scene's time 0; what lies between is a wait."""

    arrivals: list[float]
    departures: list[float]


@dataclass(frozen=True, kw_only=True, eq=False)
class HorizonRecord(Record):
    """Until when nothing can touch, whatever the obstacles with a speed limit do below it."""

    free_until: float | None
    """s; null: at no time"""
    speed_limits: dict[str, float]
    """m/s by obstacle"""


@dataclass(frozen=True, kw_only=True, eq=False)
class InTimeRecord(Record):
    """How the motion keeps clear of obstacles that move."""

    moving: list[str]
    """obstacles along a known motion"""
    waypoints: WaypointTimesRecord | None
    """null where nothing moves along a known motion"""
    horizon: HorizonRecord | None
    """null where no obstacle has a speed limit"""


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolPathRecord(Record):
    """How a tool path is followed; what is said of deviations is sampled, what is proven holds between samples."""

    followed: float
    """share of its length"""
    points: int
    """in its file"""
    largest_deviation: Deviation
    """of the path, and of the motion where there is one, which rounds the path's corners"""
    tube: TubeSize
    proven: bool
    """what is followed stays in the tube throughout, as does the motion where there is one"""
    first_unreachable: int | None
    """a point of its file, from 1"""
    speed: ToolSpeedRecord | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class LegRecord(Record):
    """A straight line of the tool at an end of a path, proven to stay in its tube; deviations are sampled."""

    leg: str
    """retreat or approach"""
    length: float
    """m"""
    largest_deviation: Deviation
    """of the path, and of the motion where there is one, which rounds the path's corners"""
    tube: TubeSize


@dataclass(frozen=True, kw_only=True, eq=False)
class PlanRecord(RunRecord):
    """What ``planner plan`` writes as plan.json; units rad, m and s."""

    reason: Annotated[NoPath, Field(discriminator="kind")] | None
    """why there is no path"""
    path: list[list[float]]
    """joint waypoints, rad (m where a joint slides), start first"""
    path_nodes: Nodes
    """their indices in the roadmap"""
    goal: str | None
    """which of the goals is reached"""
    cost: PathCost | None
    quality: QualityRecord | None
    manipulability: ManipulabilityRecord | None
    conditioning: dict[str, Any] | None
    """where w is smallest, and what to try where it is bad"""
    path_length: LengthRecord | None
    clearance: ClearanceRecord | None
    trajectory: MotionRecord | None
    kept: list[KeptRecord]
    """what path and motion keep besides limits and clearance"""
    in_time: InTimeRecord | None
    """null where no obstacle moves or may move, or no motion is"""
    roadmap: RoadmapRecord
    gabf: FieldRecord | None
    timings_s: dict[str, float]
    tool_path: ToolPathRecord | None = None
    """of ``planner follow`` only"""
    legs: list[LegRecord] | None = None
    """lines of the tool from the start and to the goal, where --approach or --retreat ask for them"""
