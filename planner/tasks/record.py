"""A task's ``plan.json``: the record that is written and read again; types and docstrings are its schema."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from planner.base.yamlfile import Name, Number
from planner.planning.network import PathCost
from planner.problem.run_schema import Record, RoadmapRecord, RunRecord

Pairs = list[tuple[Name, Name]]


@dataclass(frozen=True, kw_only=True)
class SegmentTimes(Record):
    """When a segment runs in the motion of all."""

    begin: Number
    """s"""
    duration: Number
    """s"""
    law: str
    proven: bool


@dataclass(frozen=True, kw_only=True)
class SegmentRecord(Record):
    """A stretch from rest to rest."""

    step: int
    """from 1"""
    doing: str
    """the step in words"""
    part: Literal["transit", "approach", "retreat"]
    carried: Name | None
    """what is held"""
    may_touch: Pairs
    """which things may touch along it"""
    at_rest: Pairs
    """and which at its rest only"""
    path: Annotated[list[list[Number]], Field(min_length=1)]
    """joint waypoints, rad (m where a joint slides)"""
    trajectory: SegmentTimes | None
    """null without times"""


@dataclass(frozen=True)
class Event(Record):
    """What happens at the end of a ``segment`` (from 0): ``object`` is held by ``link`` from then on, or let go of."""

    t: Number | None
    """s of the motion of all; null without times"""
    kind: Literal["attach", "detach", "gripper"]
    object: Name
    link: Name
    segment: int
    joints: dict[str, float] | None = None
    """values that the gripper's joints go to, of a gripper event"""


@dataclass(frozen=True, kw_only=True)
class StepFailsRecord(Record):
    """The first step that cannot be done."""

    kind: Literal["step_fails"]
    step: int
    """from 1"""
    doing: str
    what: Literal["no_grasp", "no_placement", "no_path"]
    tried: int
    """grasps, or pairs of a grasp and a placement"""
    out_of_reach: int
    """of these"""
    strays: int
    """and so many that leave what motions keep"""
    contacts: dict[str, int]
    """how often which two things were the first that touch"""
    conditions: list[str]
    """what motions keep"""
    beyond: float | None
    """m that the nearest is beyond where the arm can ever bring the tool; null where that is not proven of all"""


@dataclass(frozen=True, kw_only=True)
class ModesRecord(Record):
    """The network over all modes, and what was proven of it."""

    modes: int
    nodes: int
    arcs: int
    pieces_proven: int
    rounds: int
    """how often the field was solved"""
    arcs_refused: int


@dataclass(frozen=True, kw_only=True)
class TaskMotionRecord(Record):
    """The trajectory beside it, of all segments."""

    duration: float
    """s"""
    proven: bool


@dataclass(frozen=True, kw_only=True)
class TaskFieldRecord(Record):
    """How the dynamics settled."""

    law: str
    prescribed_time: float
    """T_p, s"""
    settling_time: float | None
    """s"""
    steps: int
    max_error_vs_oracle: float
    """relative, against Dijkstra's answer"""


@dataclass(frozen=True, kw_only=True)
class TaskPlanRecord(RunRecord):
    """What ``planner task`` writes as plan.json; units rad, m and s."""

    task: str
    reason: StepFailsRecord | None
    """which step cannot be done, and why"""
    path: list[list[float]]
    """joint waypoints of all segments, start first"""
    cost: PathCost | None
    segments: list[SegmentRecord]
    events: list[Event]
    trajectory: TaskMotionRecord | None
    """null without times"""
    roadmap: RoadmapRecord | None
    """null where a step has no grasp or placement at all"""
    modes: ModesRecord | None
    gabf: TaskFieldRecord | None
    timings_s: dict[str, float]
    files: dict[str, str] | None = None
    """SHA-256 of the files written beside this one"""
