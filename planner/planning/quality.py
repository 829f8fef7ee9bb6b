"""Quality of a path: gain of refinement, lower bound on the cost, w along it, worst conditioning."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import choices
from planner.cost.motion_cost import MotionCost
from planner.cost.scale import manipulability_cost
from planner.kinematics.arm import Arm
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import BANDS, manipulability, measure_name
from planner.planning.base_result import outward
from planner.problem.outcome import Record, Rows
from planner.problem.request import DEFAULT_MEASURE, Objective, PlanQuality
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot import Robot
from planner.search.manipulability_floor import find_violation, highest_floor
from planner.search.network import PathCost, build_network
from planner.trajectory.measure import dense_path, path_manipulability, w_along_path

_NOTABLE = 0.02  # share of a cost
_ROUNDING = 1e-9  # %, of a sum of costs
_BETTER = 1.2  # ratio to the smallest w from which the advice names a floor
_AT_END = 1.05  # ratio to the smallest w up to which w at an end counts as the smallest


@dataclass(frozen=True, kw_only=True, eq=False)
class PointRecord(Record):
    """The best cost after a number of rounds."""

    rounds: int
    cost: float


@dataclass(frozen=True, kw_only=True, eq=False)
class QualityRecord(Record):
    """Cost of a path against its lower bound."""

    refinement_rounds: int
    """rounds of refinement and search"""
    curve: list[PointRecord]
    lower_bound: float
    """cost below that of any path between the roadmap's starts and goals"""
    gap: float | None
    """upper bound on the relative distance of the cost from the optimum"""
    manipulability_cost: float | None
    """Omega of the path in steps of 0.01 rad; ``cost`` uses few states per edge; null if integrated over nodes"""

    @classmethod
    def from_path(
        cls,
        quality: PlanQuality,
        roadmap: Roadmap,
        robot: Robot,
        path: Floats,
        total: float,
        curve: tuple[tuple[int, float], ...],
    ) -> Self:
        """Return the quality of a path (k, dof) of ``roadmap`` with cost ``total``."""
        bound, finely = cost_lower_bound(roadmap, robot, quality.objective), None
        if quality.cost_integration == "edges":
            alone, states = replace(quality.objective, beta=0.0, floor=0.0), dense_path(path)
            cost = MotionCost(robot, roadmap.scale, alone, longest=np.inf, states=3).for_pieces
            finely = float(cost(states[:-1], states[1:]).sum())
        points = [PointRecord(rounds=rounds, cost=cost) for rounds, cost in curve]
        gap = total / bound - 1.0 if bound > 0 else None
        return cls(
            refinement_rounds=quality.rounds, curve=points, lower_bound=bound, gap=gap, manipulability_cost=finely
        )

    def rows(self, cost: PathCost, in_time: bool) -> Rows:
        """Return rows for the lower bound and the gain of refinement; ``in_time`` omits the gap."""
        rows, finely = [], self.manipulability_cost
        if finely is not None and cost.beta < 1.0 and finely > (1.0 + _NOTABLE) * cost.manipulability:
            more = f"{100 * (finely / cost.manipulability - 1.0):.1f} % more: w dips between states"
            rows.append(("integral", f"{finely:.4f} manipulability in pieces of 0.01 rad, {more}"))
        ends, apart = "between the roadmap's start and goal configurations", ""
        if self.gap is not None and not in_time:
            share = max(0.0, 100 * self.gap - _ROUNDING)
            apart = f"; this path is at most {outward(share, 1, up=True)} % above the optimum between them"
        rows.append(("bound", f"no path {ends} costs less than {outward(self.lower_bound, 4, up=False)}{apart}"))
        if len(self.curve) > 1:
            first, last = self.curve[0], self.curve[-1]
            rows.append(
                ("refinement", f"{last.rounds} rounds took the best cost from {first.cost:.4f} to {last.cost:.4f}")
            )
        return rows


def cost_lower_bound(roadmap: Roadmap, robot: Robot, objective: Objective) -> float:
    """Return a lower bound on the cost of every path between the starts and goals of ``roadmap``.

    A path is at least as long as the straight line between its ends, in joint space or (metric "workspace") of the
    tool, and omega is at least ``scale.zeta``: their product bounds the integral over edges. Integrated over nodes,
    every path pays the omega of its goal at least. The bound is the minimum over all pairs of start and goal.
    """
    starts, goals = roadmap.nodes[roadmap.starts], roadmap.nodes[roadmap.goals]
    away = robot.difference(starts[:, None], goals[None])
    if objective.metric == "joint":
        distance = np.linalg.norm(away, axis=2) / roadmap.scale.joint_length
    else:
        ends = [(tool_positions(one, starts), tool_positions(one, goals)) for one in robot.with_each_tool]
        lengths = [np.linalg.norm(here[:, None] - there[None], axis=2) for here, there in ends]
        distance = np.sum(lengths, axis=0) / roadmap.scale.tool_length
    if objective.cost_integration == "edges":
        omega = roadmap.scale.zeta * distance
    else:
        w, name = roadmap.manipulability[roadmap.goals], objective.manipulability_cost
        omega = np.broadcast_to(manipulability_cost(w, roadmap.scale, name), distance.shape)
    return float(np.where(away.any(axis=2), objective.total(omega, distance), 0.0).min())


@dataclass(frozen=True, kw_only=True, eq=False)
class FloorRecord(Record):
    """The manipulability floor, and whether the path stays above it."""

    asked: float
    start: float
    """w at the start"""
    goal: float
    """w at the goal"""
    reached: bool
    holds: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolRecord(Record):
    """The w of one of several tools along the path."""

    frame: str
    min: float
    mean: float

    @classmethod
    def from_path(cls, robot: Arm, path: Floats) -> Self:
        """Return the record of w along a path (k, dof) for the tool of ``robot``."""
        w = manipulability(robot, dense_path(path))
        return cls(frame=robot.tool, min=float(w.min()), mean=float(w.mean()))


@dataclass(frozen=True, kw_only=True, eq=False)
class ManipulabilityRecord(Record):
    """Yoshikawa's w, or another measure, sampled densely along the path: the least of all tools."""

    min: float
    mean: float
    rows: str
    """rows of the Jacobian: pose, translation, rotation or planar"""
    measure: str
    """yoshikawa, or another measure"""
    frame: str
    """the tool; several with commas between"""
    floor: FloorRecord | None = None
    tools: list[ToolRecord] | None = None
    """w of each of several tools; null for one"""

    @classmethod
    def from_path(cls, robot: Robot, path: Floats, floor: float) -> Self:
        """Return the record of w along a path (k, dof), with its ``floor`` if that is positive."""
        w, record = path_manipulability(robot, path), None
        if floor > 0:
            start, goal = (float(end) for end in manipulability(robot, path[[0, -1]]))
            holds = find_violation(robot, path, floor) is None
            record = FloorRecord(asked=floor, start=start, goal=goal, reached=bool(w.max() >= floor), holds=holds)
        return cls(
            min=float(w.min()),
            mean=float(w.mean()),
            rows=robot.jacobian_rows,
            measure=measure_name(robot.measure),
            frame=robot.tool_text,
            floor=record,
            tools=[ToolRecord.from_path(one, path) for one in robot.with_each_tool] if robot.other_tools else None,
        )

    @property
    def text(self) -> str:
        text = f"min {self.min:.5f}, mean {self.mean:.5f} along the path ({self.rows} rows of the Jacobian)"
        if self.tools:
            text += f"; the least of {choices(f'{one.min:.5f} of {one.frame}' for one in self.tools)}"
        if self.measure != DEFAULT_MEASURE:
            return f"{text}: {self.measure} in place of w, sampled; no floor is proven for it"
        if self.floor is None:
            return text
        asked, ends = self.floor.asked, min(self.floor.start, self.floor.goal)
        if not self.floor.holds:
            return f"{text}; NOT above the floor of {asked:g}"
        if not self.floor.reached:
            return f"{text}; it never reaches the floor of {asked:g}, and stays above its lower end's {ends:.5f}"
        low = "" if ends >= asked else f" but for the stretches from and to its ends, of w {ends:.5f}"
        return f"{text}; above the floor of {asked:g}{low}"


@dataclass(frozen=True, kw_only=True, eq=False)
class Conditioning(Record):
    """The smallest w of the path compared to the roadmap's median."""

    w_min: float
    typical: float
    """the median of w over the roadmap's nodes"""
    poor: bool
    share: float
    """of the path's length (rad), where w is smallest"""
    reachable_floor: float | None
    """highest floor that a path of the roadmap keeps; null if the path is not poor"""
    advice: str | None
    """remedies; null if the path is not poor"""


def measure_conditioning(robot: Robot, roadmap: Roadmap, path: Floats, quality: PlanQuality) -> Conditioning:
    """Return the conditioning of a path (k, dof) of ``roadmap``, sampled ``W_ALONG_PATH`` apart."""
    (along, w), typical = w_along_path(robot, path), float(np.median(roadmap.manipulability))
    lowest = int(w.argmin())
    w_min, share = float(w[lowest]), float(along[lowest] / along[-1]) if along[-1] > 0 else 0.0
    poor, floor, advice = bool(w_min < BANDS["poor"] * typical), None, None
    if poor:
        floor = highest_floor(robot, roadmap, build_network(roadmap, quality.objective))
        at_ends = [end for end, k in (("start", 0), ("goal", -1)) if w[k] <= _AT_END * w_min]
        where = f"at the {at_ends[0]} itself" if at_ends else f"at {100 * share:.0f} % of the path"
        advice = (
            f"Badly conditioned {where}: w {w_min:.2g} there is {100 * w_min / typical:.2g} % of the roadmap's median "
            f"{typical:.2g}. Try {'; or '.join(_remedies(w_min, floor, at_ends, quality))}."
        )
    return Conditioning(w_min=w_min, typical=typical, poor=poor, share=share, reachable_floor=floor, advice=advice)


def _remedies(w_min: float, floor: float, at_ends: list[str], quality: PlanQuality) -> list[str]:
    """Return remedies for the smallest w ``w_min``; ``at_ends`` names the ends where it occurs."""
    tries = []
    if floor > _BETTER * max(w_min, quality.min_manipulability):
        tries.append(f"--min-manipulability {floor:g}, above which a path of this roadmap stays")
    if quality.beta == 1.0:
        tries.append("a --beta below 1")
    elif quality.cost_integration == "nodes":
        tries.append("--cost-integration edges")
    return tries or ([f"another {at_ends[0]}"] if at_ends else ["more --nodes", "another --seed"])
