"""A task's ``plan.json``: the record that is written and read again; types and docstrings are its schema."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from planner.base.errors import Reason, choices, metric
from planner.base.yamlfile import Name, Number, Whole
from planner.planning.run import FieldRecord, MotionRecord, RunRecord, cost_text
from planner.problem.outcome import Record, Rows
from planner.roadmap.roadmap import RoadmapRecord
from planner.search.network import PathCost

Pairs = list[tuple[Name, Name]]
Part = Literal["transit", "approach", "retreat"]
_NAMED = 3  # contacts in the sentence


@dataclass(frozen=True, kw_only=True, eq=False)
class SegmentTimes(Record):
    """When a segment runs in the motion of all."""

    begin: Number
    """s"""
    duration: Number
    """s"""
    law: str
    proven: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class SegmentRecord(Record):
    """A stretch from rest to rest."""

    step: Whole
    """from 1"""
    doing: str
    """the step in words"""
    part: Part
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
    segment: Whole
    position: Annotated[list[Number], Field(min_length=3, max_length=3)] | None = None
    """m: where the object stands then, of an attach or detach event"""
    quaternion: Annotated[list[Number], Field(min_length=4, max_length=4)] | None = None
    """x, y, z, w: and how it is turned"""
    joints: dict[str, Number] | None = None
    """values that the gripper's joints go to, of a gripper event"""


@dataclass(frozen=True, kw_only=True, eq=False)
class StepFails(Reason):
    """The first step that cannot be done: no grasp or placement of it is left, or no path leads there."""

    kind: Literal["step_fails"] = "step_fails"
    step: Whole
    """from 1"""
    doing: str
    """the step in words"""
    what: Literal["no_grasp", "no_placement", "no_path"]
    tried: int
    """grasps, or pairs of a grasp and a placement"""
    out_of_reach: int
    """of these"""
    strays: int
    """and so many that leave what motions keep"""
    contacts: dict[str, int]
    """how often which two things were the first that touch, where all configurations of one were in contact"""
    conditions: tuple[str, ...] = ()
    """what motions keep"""
    beyond: float | None = None
    """m that the nearest is beyond where the arm can ever bring the tool: as much nearer is the least that could work;
    null where that is not proven of all"""

    @property
    def names(self) -> frozenset[str]:
        return frozenset(part.strip("'") for pair in self.contacts for part in pair.split("' and '"))

    @property
    def sentence(self) -> str:
        head = f"Step {self.step} ({self.doing}) cannot be done: "
        found = f"{self.out_of_reach} of {self.tried} out of reach"
        found += f" (the nearest by {metric(self.beyond, 'm')} or more)" if self.beyond else ""
        for pair, count in list(self.contacts.items())[:_NAMED]:
            found += f", {count} in contact ({pair})"
        if self.strays:
            found += f", {self.strays} straying from what is kept ({choices(self.conditions)})"
        less = ", or keep less" if self.strays else ""
        match self.what:
            case "no_grasp":
                return f"{head}no grasp is left, {found}: move the object or the robot, or give other grasps{less}."
            case "no_placement":
                return f"{head}no placement is left, {found}: give another region, or more samples{less}."
        seen = f" ({found})" if self.tried else ""
        return f"{head}no path leads there within the budget{seen}: raise --nodes, or try another --seed."


@dataclass(frozen=True, kw_only=True, eq=False)
class ModesRecord(Record):
    """The network over all modes, and what was proven of it."""

    modes: int
    nodes: int
    arcs: int
    pieces_proven: int
    rounds: int
    """how often the field was solved"""
    arcs_refused: int


@dataclass(frozen=True, kw_only=True, eq=False)
class TaskPlanRecord(RunRecord):
    """What ``planner task`` writes as plan.json; units rad, m and s."""

    task: str
    reason: StepFails | None
    """which step cannot be done, and why"""
    path: list[list[float]]
    """joint waypoints of all segments, start first"""
    cost: PathCost | None
    segments: list[SegmentRecord]
    events: list[Event]
    trajectory: MotionRecord | None
    """of all segments; null without times"""
    roadmap: RoadmapRecord | None
    """null where a step has no grasp or placement at all"""
    modes: ModesRecord | None
    gabf: FieldRecord | None

    @property
    def rows(self) -> Rows:
        rows: Rows = [] if self.roadmap is None else [("roadmap", self.roadmap.text)]
        if self.modes is not None:
            m = self.modes
            rows.append(("modes", f"{m.modes} over {m.nodes} nodes, {m.arcs_refused} of {m.arcs} arcs refused"))
        if self.cost is not None:
            rows.append(("cost", cost_text(self.cost)))
        for k, segment in enumerate(self.segments, start=1):
            held, timed = f", holding {segment.carried}" if segment.carried else "", segment.trajectory
            motion = f", {timed.duration:.2f} s{'' if timed.proven else ', NOT proven'}" if timed else ""
            what = f"step {segment.step}, {segment.doing}: {segment.part}{held}{motion}"
            rows.append((f"segment {k}", what))
        if self.trajectory is not None:
            proven = "all proven" if self.trajectory.proven else "not all proven"
            rows.append(("motion", f"{self.trajectory.duration:.2f} s, {proven}"))
        return rows + (self.gabf.rows if self.gabf else [])
