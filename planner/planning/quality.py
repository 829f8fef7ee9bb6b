"""How good a path is: what its cost is at least, on whatever roadmap, and what refinement gained."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from planner.base.arrays import Floats
from planner.cost.motion_cost import MotionCost
from planner.cost.scale import manipulability_cost
from planner.kinematics.forward import tool_positions
from planner.planning.run import outward
from planner.problem.objective import Metric, Objective
from planner.problem.outcome import Record, Rows
from planner.problem.request import PlanRequest
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot import Robot
from planner.search.network import PathCost
from planner.trajectory.measure import corners, dense_path

_NOTABLE = 0.02  # share of a cost
_ROUNDING = 1e-9  # %, of a cost that is a sum


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

    @classmethod
    def of(
        cls,
        request: PlanRequest,
        roadmap: Roadmap,
        robot: Robot,
        path: Floats,
        total: float,
        curve: tuple[tuple[int, float], ...],
    ) -> Self:
        """The quality of a path (k, dof) of ``roadmap`` that costs ``total``."""
        bound = cost_lower_bound(roadmap, robot, request.objective)
        return cls(
            effort=request.rounds,
            curve=[PointRecord(rounds=rounds, cost=cost) for rounds, cost in curve],
            lower_bound=bound,
            gap=total / bound - 1.0 if bound > 0 else None,
            manipulability_cost=_cost_in_pieces(request.objective, roadmap, robot, path),
            corners=corners(path),
        )

    def rows(self, cost: PathCost, in_time: bool) -> Rows:
        """The bound on the cost, and what the effort gained; ``in_time`` it is not the cost that decides."""
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
            text = f"{last.rounds} rounds took the best cost from {first.cost:.4f} to {last.cost:.4f}"
            rows.append(("effort", text))
        return rows


def cost_lower_bound(roadmap: Roadmap, robot: Robot, objective: Objective) -> float:
    """A lower bound on the cost, as the network of ``roadmap`` charges it, of every path from a start to a goal.

    Starts and goals are the roadmap's: of what is asked of the tool, other configurations may be nearer to each other.
    No path is shorter than the straight line between its ends, in joint space or (metric "workspace") from tool to
    tool. omega is nowhere below ``scale.zeta``: integrated over that length it costs so much at least. Charged at
    nodes, the goal's own omega is all that every path pays. The least of all pairs of a start and a goal counts.
    """
    starts, goals = roadmap.nodes[roadmap.starts], roadmap.nodes[roadmap.goals]
    distance = _straight(robot, starts, goals, objective.metric)
    distance /= roadmap.scale.joint_length if objective.metric == "joint" else roadmap.scale.tool_length
    moves = (robot.difference(starts[:, None], goals[None]) != 0).any(axis=2)
    if objective.charge == "edges":
        omega = roadmap.scale.zeta * distance
    else:
        name, w = objective.manipulability_cost, roadmap.manipulability[roadmap.goals]
        omega = np.broadcast_to(manipulability_cost(w, roadmap.scale, name), moves.shape)
    return float(np.where(moves, objective.total(omega, distance), 0.0).min())


def _straight(robot: Robot, starts: Floats, goals: Floats, metric: Metric) -> Floats:
    """(s, g) straight-line lengths, rad of joint motion or metres of the tool's."""
    if metric == "joint":
        return np.linalg.norm(robot.difference(starts[:, None], goals[None]), axis=2)
    here, there = (tool_positions(robot, q) for q in (starts, goals))
    return np.linalg.norm(here[:, None] - there[None], axis=2)


def _cost_in_pieces(objective: Objective, roadmap: Roadmap, robot: Robot, path: Floats) -> float | None:
    """Omega of a path (k, dof) in pieces of 0.01 rad, where edges are priced by few states; None if at nodes."""
    if objective.charge == "nodes":
        return None
    states = dense_path(path)
    alone = replace(objective, beta=0.0, floor=0.0)
    cost = MotionCost(robot, roadmap.scale, alone, longest=np.inf, states=3).of_pieces
    return float(cost(states[:-1], states[1:]).sum())
