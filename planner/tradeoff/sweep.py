"""The exact trade-off: every path that some beta makes optimal on one roadmap, with the betas it is optimal for."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np

from planner import gabf
from planner.base.arrays import frozen
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.planning.improvement import improved_roadmap, roomy_roadmap
from planner.planning.result import Plan
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, SweepQuality, SweepRequest
from planner.query.query import Query, make_query
from planner.roadmap.obtain import obtain_roadmap
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.robot.robot import Robot
from planner.search.manipulability_floor import LayeredNetwork
from planner.search.network import build_network
from planner.search.search import ProvenNetwork, RoadmapPaths, second_looks
from planner.tradeoff.envelope import EnvelopeSearch, Piece, pieces
from planner.tradeoff.result import Interval, Tradeoff
from planner.trajectory.measure import measure_path
from planner.view.motion import ShownPath, path_rows

IMPROVED_AT = (0.0, 0.25, 0.5, 0.75, 1.0)  # betas at which the roadmap is improved before the sweep


def sweep(request: SweepRequest | PlanRequest, progress: Progress = QUIET) -> Tradeoff:
    """The whole trade-off between manipulability and distance, on a roadmap that is obtained once.

    Every path is checked again at every 1 mm of motion, as a plan's is; a path that fails is removed and the sweep
    restarts. ``progress`` is called with (stage, done, total), for stage "beta" with the per cent of [0, 1] that are
    settled; once it is asked to stop the sweep ends soon after and returns the intervals that are proven, with
    ``Outcome.INTERRUPTED``. Raises :class:`PlannerError` for unusable input.
    """
    clock, quality = Stopwatch(), request.quality
    with clock("setup"):
        query = make_query(request.what, progress=progress)
    with clock("roadmap"):
        roadmap, clearance = _improved_roadmap(quality, query, progress)
    robot, checker = query.robot, query.checker
    draft = Tradeoff(request, Outcome.INTERRUPTED, checker, roadmap, clearance=clearance, timings=clock.seconds)
    if progress.stopped:
        return draft
    with clock("costs"):
        network, floor = build_network(roadmap, quality.objective_at(0.5), clearance), quality.min_manipulability
        paths = RoadmapPaths(roadmap, robot, network, floor, second_looks(checker, roadmap, progress=progress))
    search = EnvelopeSearch(paths, gabf.named_law(quality.law, quality.prescribed_time), clock)
    while not search.done and not progress.stopped:
        search.step()
        progress("beta", int(100 * search.reach), 100)
    draft = replace(
        draft,
        roadmap=paths.roadmap,
        layered=paths.layered,
        edges_removed=int((~paths.kept).sum()),
        solves=search.solves,
        max_error_vs_oracle=search.max_error if search.solves else None,
    )
    if not search.connected:
        return replace(draft, outcome=Outcome.TOO_SINGULAR if floor > 0 else Outcome.NO_PATH)
    with clock("measures"):
        known = pieces(search.supports[: search.settled + 1])
        intervals = tuple(_interval(piece, paths, robot) for piece in (known if search.done else known[:-1]))
    outcome = Outcome.SOLVED if search.done else Outcome.INTERRUPTED
    return replace(draft, intervals=intervals, complete=search.done, outcome=outcome)


def _improved_roadmap(quality: SweepQuality, query: Query, progress: Progress) -> tuple[Roadmap, float]:
    """The roadmap that ``quality`` names or grows, improved at several betas, and the clearance (m) that paths keep.

    A kept roadmap that is not refined stays as it is.
    """
    roadmap, clearance = obtain_roadmap(quality, query, progress), 0.0
    if quality.rounds < 1:
        return roadmap, clearance
    roadmap, clearance = roomy_roadmap(roadmap, query.checker, quality, progress)
    for beta in IMPROVED_AT:
        roadmap = improved_roadmap(roadmap, query.checker, quality, beta, progress, clearance).roadmap
    return roomy_roadmap(roadmap, query.checker, quality, progress)  # now with the edges of the improvements


def _interval(piece: Piece, paths: RoadmapPaths, robot: Robot) -> Interval:
    support, path = piece.support, paths.waypoints(piece.support.nodes)
    assert support.cost_to_go is not None  # a sweep runs the dynamics
    return Interval(
        beta_min=piece.beta_min,
        beta_max=piece.beta_max,
        path_nodes=frozen(paths.layered.roadmap_node[support.nodes], np.int64),
        path=path,
        manipulability_cost=support.manipulability,
        distance_cost=support.distance,
        cost_to_go=support.cost_to_go,
        **asdict(measure_path(robot, path)),
    )


def with_alternatives(plan: Plan, progress: Progress = QUIET) -> Plan:
    """The plan with the paths that every other beta would choose on its network, for its page; a search of its own.

    One path for every interval of beta, sorted; none where the search was stopped. They consist of proven edges, and
    are not checked a second time. Their fields are the oracle's, which the dynamics would settle at. Where obstacles
    move there are none: no beta chooses among motions in time.
    """
    if plan.layered is None or plan.cost is None or plan.scene.moving:
        return plan
    clock = Stopwatch()
    with clock("alternatives"):
        found = _paths_for_every_beta(plan, plan.layered, progress)
    return replace(plan, alternatives=found, timings=plan.timings | clock.seconds)


def _paths_for_every_beta(plan: Plan, layered: LayeredNetwork, progress: Progress) -> tuple[ShownPath, ...]:
    search = EnvelopeSearch(ProvenNetwork(layered.network, layered.starts))
    while not search.done:
        if progress.stopped:
            return ()
        search.step()
        progress("other betas", int(100 * search.reach), 100)
    shown = []
    for piece in pieces(search.supports):
        support = piece.support
        path = path_waypoints(plan.roadmap, plan.robot, layered.roadmap_node[support.nodes])
        costs = support.manipulability, support.distance
        rows, field = path_rows(plan.robot, path, *costs), layered.on_roadmap(support.x)
        shown.append(ShownPath(path, rows, (piece.beta_min, piece.beta_max), field, costs))
    return tuple(shown)
