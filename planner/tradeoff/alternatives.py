"""What a page shows of a plan or a trade-off: one path an interval of beta, each with its numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.outcome import Outcome
from planner.costs.manipulability_floor import LayeredNetwork
from planner.paths.measure import measure_path
from planner.planning import Plan
from planner.roadmap.roadmap import path_waypoints
from planner.tradeoff.envelope import EnvelopeSearch, Piece, pieces
from planner.tradeoff.sweep import Tradeoff, reached_by_beta
from planner.world.robot import Robot

Rows = list[tuple[str, str]]
MOST_BEYOND = 30  # paths that no beta reaches, drawn at most: each is some ten kilobytes of a page
W_UNIT = {"pose": "m³", "translation": "m³", "planar": "m²"}


@dataclass(frozen=True, eq=False)
class ShownPath:
    """A path (k, dof) rad, what is said about it, and where known its betas and the cost-to-go (n,) of the roadmap.

    ``costs``: Omega and D. A path with costs but without an interval is non-dominated, and no beta makes it optimal.
    """

    path: Floats
    numbers: Rows
    interval: tuple[float, float] | None = None
    cost_to_go: Floats | None = None
    costs: tuple[float, float] | None = None


def paths_for_every_beta(plan: Plan) -> tuple[list[ShownPath], int]:
    """The paths for every beta on the plan's roadmap, and which of them is the plan's own; none without a path.

    The alternatives consist of proven edges; only the plan's own path was looked at again at every millimetre, and
    held against a manipulability floor between the states that the roadmap keeps.
    """
    if plan.outcome is not Outcome.SOLVED:
        return [], 0
    assert plan.layered is not None
    assert plan.cost is not None
    search = EnvelopeSearch(
        plan.layered.network, plan.layered.starts, gabf.named_law(plan.request.law, plan.request.prescribed_time)
    )
    while not search.done:
        search.step()
    beta = plan.request.beta
    found = pieces(search.supports)
    shown = [_of_piece(plan, plan.layered, piece) for piece in found]
    for k, piece in enumerate(found):
        same = np.isclose([piece.support.manipulability, piece.support.distance], [*_costs(plan)], rtol=1e-9).all()
        if same and piece.beta_min <= beta <= piece.beta_max:
            shown[k] = _planned(plan, (piece.beta_min, piece.beta_max))
            return shown, k
    # as good as the others at this one beta, as may be at 0, at 1 and where two intervals meet
    place = sum(piece.beta_min < beta for piece in found)
    shown.insert(place, _planned(plan, (beta, beta)))
    return shown, place


def of_tradeoff(tradeoff: Tradeoff) -> list[ShownPath]:
    """The trade-off's paths; those that are proven so far where it was interrupted. Those that no beta reaches last."""
    optimal = [
        ShownPath(
            item.path,
            path_rows(tradeoff.robot, item.path, item.manipulability_cost, item.distance_cost),
            (item.beta_min, item.beta_max),
            on_roadmap(tradeoff.layered, item.cost_to_go),
            (item.manipulability_cost, item.distance_cost),
        )
        for item in tradeoff.intervals
    ]
    return [*optimal, *_beyond_beta(tradeoff)]


def count_beyond_beta(tradeoff: Tradeoff) -> int:
    """How many non-dominated paths no beta reaches, where they were asked for."""
    return len(_rows_beyond_beta(tradeoff))


def _rows_beyond_beta(tradeoff: Tradeoff) -> Ints:
    if tradeoff.front is None:
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(~reached_by_beta(tradeoff.front.points, tradeoff.intervals))


def _beyond_beta(tradeoff: Tradeoff) -> list[ShownPath]:
    """Non-dominated paths that no beta reaches by Omega; of many, some evenly spread over all."""
    rows = _rows_beyond_beta(tradeoff)
    if len(rows) > MOST_BEYOND:
        rows = rows[np.linspace(0, len(rows) - 1, MOST_BEYOND).round().astype(np.int64)]
    shown: list[ShownPath] = []
    for row in rows:
        assert tradeoff.front is not None
        path = path_waypoints(tradeoff.roadmap, tradeoff.robot, tradeoff.front.paths[row])
        omega, distance = tradeoff.front.points[row].tolist()
        shown.append(ShownPath(path, path_rows(tradeoff.robot, path, omega, distance), costs=(omega, distance)))
    return shown


def path_rows(robot: Robot, path: Floats, omega: float, distance: float) -> Rows:
    """What the page says about a path: its two costs, w along it, its lengths."""
    measures, unit = measure_path(robot, path), W_UNIT[robot.manipulability]
    return [
        ("manipulability cost Ω", f"{omega:.4f}"),
        ("distance cost D", f"{distance:.4f}"),
        (f"w smallest ({unit})", f"{measures.w_min:.3g}"),
        (f"w mean ({unit})", f"{measures.w_mean:.3g}"),
        ("joint motion", f"{measures.joint_length:.3f} rad"),
        ("tool's way", f"{measures.workspace_length:.3f} m"),
        ("waypoints", str(len(path))),
    ]


def _planned(plan: Plan, interval: tuple[float, float]) -> ShownPath:
    rows = path_rows(plan.robot, plan.path, *_costs(plan))
    return ShownPath(plan.path, rows, interval, on_roadmap(plan.layered, plan.cost_to_go), _costs(plan))


def _of_piece(plan: Plan, layered: LayeredNetwork, piece: Piece) -> ShownPath:
    support = piece.support
    path = path_waypoints(plan.roadmap, plan.robot, layered.roadmap_node[support.nodes])
    rows = path_rows(plan.robot, path, support.manipulability, support.distance)
    costs = support.manipulability, support.distance
    return ShownPath(path, rows, (piece.beta_min, piece.beta_max), on_roadmap(layered, support.cost_to_go), costs)


def _costs(plan: Plan) -> tuple[float, float]:
    assert plan.cost is not None
    return plan.cost.manipulability, plan.cost.distance


def on_roadmap(layered: LayeredNetwork | None, cost_to_go: gabf.CostToGo | None) -> Floats | None:
    """The cost-to-go (n,) of the roadmap's own nodes; where a floor has several stretches, a node's least on any."""
    if layered is None or cost_to_go is None:
        return None
    least = np.full(layered.roadmap_node.max() + 1, np.inf)
    np.minimum.at(least, layered.roadmap_node, cost_to_go.x)
    return least
