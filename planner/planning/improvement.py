"""A roadmap improved for what a request asks for: its best path refined, others searched, all of it made part of it."""

from dataclasses import replace

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker, with_extra_margin
from planner.collision.edge_prover import EdgeProver
from planner.cost.motion_cost import MotionCost
from planner.kinematics.manipulability import manipulability
from planner.native.graphs import reachable
from planner.planning.result import Curve, Plan
from planner.problem.request import PlanQuality, SweepQuality
from planner.roadmap.improve import Improvement, improve, remove_last_grown
from planner.roadmap.roadmap import Roadmap, edge_motions, path_waypoints
from planner.search.manipulability_floor import layered_network
from planner.search.network import build_network, cheapest_steps
from planner.trajectory.measure import path_manipulability

_ROUNDS_ABOVE_ENDS = 2  # where nothing but the cost decides
IMPROVED_AT = (0.5, 0.0, 1.0)  # betas for which every roadmap is improved, a plan's and a sweep's
_SEEDS_APART = 1000  # else each stage would try again what the one before it has tried
_HALVES = 6  # 5 mm: down to 0.16 mm, where proofs end
_ROUNDING = 1e-9  # relative: w of one state computed from two ends of an edge


def improve_plan(draft: Plan, progress: Progress) -> Plan:
    """The plan on a roadmap whose best path is refined; a new one keeps the number of nodes that was asked for.

    The roadmap is that of a sweep, improved further at the plan's own beta: its path costs no more than the sweep's.
    """
    quality, checker = draft.request.quality, draft.checker
    roadmap, room, curves = improve_for_all_betas(draft.roadmap, checker, quality, progress, quality.beta)
    if quality.beta == 0.0 and quality.min_manipulability <= 0:
        roadmap = add_path_without_dip(roadmap, checker, quality, progress, room)
    if quality.roadmap is None:
        roadmap = trim_roadmap(roadmap, len(draft.roadmap.nodes), quality, room)
    return replace(draft, roadmap=roadmap, curve=curves.get(quality.beta, ()), clearance_kept=room)


def improve_for_all_betas(
    roadmap: Roadmap,
    checker: CollisionChecker,
    quality: SweepQuality,
    progress: Progress = QUIET,
    own: float = IMPROVED_AT[0],
) -> tuple[Roadmap, float, dict[float, Curve]]:
    """The roadmap improved at each of ``IMPROVED_AT``, then at ``own``; the clearance (m) that paths keep, and curves.

    Each beta has half the rounds. A kept roadmap that is not to be refined stays as it is.
    """
    if quality.roadmap is not None and quality.rounds < 1:
        return roadmap, 0.0, {}
    (roadmap, room), curves = with_min_clearance(roadmap, checker, quality, progress), dict[float, Curve]()
    betas = IMPROVED_AT if own == IMPROVED_AT[0] else (*IMPROVED_AT, own)
    for place, beta in enumerate(betas):
        seed = (quality.seed + _SEEDS_APART * place) % 2**31
        part = replace(quality, refinement_rounds=-(-quality.rounds // 2), seed=seed)
        whole = progress.with_report(lambda *of, k=place: progress(of[0], k * of[2] + of[1], len(betas) * of[2]))
        found = improve_roadmap(roadmap, checker, part, beta, whole, room)
        roadmap, curves[beta] = found.roadmap, found.curve
    return roadmap, room, curves


def with_min_clearance(
    roadmap: Roadmap, checker: CollisionChecker, quality: SweepQuality, progress: Progress = QUIET
) -> tuple[Roadmap, float]:
    """The roadmap with new certificates of its edges, and the clearance (m) beyond the margin that its paths keep.

    That is ``quality.extra_clearance``, or half of it, a quarter, ...: the largest at which edges lead from a start to
    a goal, above the floor if one is asked for; else 0. A path that has been made short or well conditioned grazes the
    obstacles, so the edges of a plan's network, the motions that refinement tries and the shortcuts in time keep it.
    """

    def joins(clearance: float) -> bool:
        if quality.min_manipulability > 0:
            return len(_best_nodes(roadmap, quality, 1.0, clearance)) > 0
        edges, begin = roadmap.edges[roadmap.clearance >= clearance], np.zeros(len(roadmap.nodes), dtype=bool)
        begin[roadmap.starts] = True
        return bool(reachable(begin, np.concatenate([edges, edges[:, ::-1]]))[roadmap.goals].any())

    if quality.extra_clearance <= 0 or not joins(0.0):
        return roadmap, 0.0
    for clearance in halves(quality.extra_clearance):
        roadmap = _with_proofs(roadmap, checker, clearance, progress)
        if progress.stopped:
            break
        if joins(clearance):
            return roadmap, clearance
    return roadmap, 0.0


def improve_roadmap(
    roadmap: Roadmap,
    checker: CollisionChecker,
    quality: SweepQuality,
    beta: float,
    progress: Progress = QUIET,
    clearance: float = 0.0,
) -> Improvement:
    """``quality.rounds`` rounds of :func:`planner.roadmap.improve.improve` at ``beta``, from its best path.

    That path, and what takes its place, keeps ``clearance`` (m) beyond the margin. With a floor only the part of that
    path above it is improved, and stays above it. Nothing is improved where the roadmap has no path, or none above the
    floor.
    """
    if quality.rounds < 1 or progress.stopped:
        return Improvement(roadmap)
    path = path_waypoints(roadmap, checker.robot, _best_nodes(roadmap, quality, beta, clearance))
    above = np.flatnonzero(manipulability(checker.robot, path) >= quality.min_manipulability)
    if len(above) < 2:
        return Improvement(roadmap)
    cost = motion_cost(roadmap, checker, quality, beta)
    part, wider = path[above[0] : above[-1] + 1], with_extra_margin(checker, clearance)
    return improve(roadmap, wider, cost, part, quality.rounds, quality.seed, progress, clearance=clearance)


def add_path_without_dip(
    roadmap: Roadmap,
    checker: CollisionChecker,
    quality: PlanQuality,
    progress: Progress = QUIET,
    clearance: float = 0.0,
) -> Roadmap:
    """The roadmap with a path whose w does not fall below both its ends' w, as far as a few rounds find one.

    The roadmap is returned as it was where its best path is such a path.
    """
    path = path_waypoints(roadmap, checker.robot, _best_nodes(roadmap, quality, quality.beta, clearance))
    rounds = min(quality.rounds, _ROUNDS_ABOVE_ENDS)
    if len(path) < 2 or rounds < 1:
        return roadmap
    w = path_manipulability(checker.robot, path)
    level = (1.0 - _ROUNDING) * float(min(w[0], w[-1]))
    if w.min() >= level:
        return roadmap
    cost = motion_cost(roadmap, checker, quality, quality.beta).above(level)
    wider = with_extra_margin(checker, clearance)
    return improve(roadmap, wider, cost, None, rounds, quality.seed, progress, path, clearance).roadmap


def motion_cost(roadmap: Roadmap, checker: CollisionChecker, quality: SweepQuality, beta: float) -> MotionCost:
    """What motions cost at ``beta`` on the network of ``roadmap`` that the request asks for."""
    return MotionCost(checker.robot, roadmap.scale, quality.objective_at(beta))


def trim_roadmap(roadmap: Roadmap, grown: int, quality: PlanQuality, clearance: float = 0.0) -> Roadmap:
    """An improved roadmap, ``grown`` of whose nodes were grown, with the number of nodes that was asked for."""
    if len(roadmap.nodes) <= quality.nodes:
        return roadmap
    best = _best_nodes(roadmap, quality, quality.beta, clearance)
    return remove_last_grown(roadmap, grown, quality.nodes, best)


def _best_nodes(roadmap: Roadmap, quality: SweepQuality, beta: float, clearance: float) -> Ints:
    """The nodes (k,) of the best path at ``beta`` that keeps ``clearance`` (m), and the floor that is asked for."""
    network = build_network(roadmap, quality.objective_at(beta), clearance)
    layered = layered_network(roadmap, network, quality.min_manipulability)
    return layered.roadmap_node[cheapest_steps(layered.network, layered.starts)]


def _with_proofs(roadmap: Roadmap, checker: CollisionChecker, clearance: float, progress: Progress) -> Roadmap:
    """With a proof of each edge whose certificate leaves open whether it has so much ``clearance`` (m)."""
    rows = np.flatnonzero(roadmap.clearance < clearance)
    wider = with_extra_margin(checker, clearance)
    prover = EdgeProver(wider, progress, "clearance")
    proofs = prover.prove(*edge_motions(roadmap, checker.robot, rows), contacts=False)
    known, free = roadmap.clearance.copy(), proofs.free
    known[rows[free]] = clearance + np.maximum(proofs.clearance[free], 0.0)
    return replace(roadmap, clearance=known)


def prove_path_clearance(path: Floats, checker: CollisionChecker, wanted: float) -> float:
    """The largest of ``wanted``, its half, ... (m) that all motions of a ``path`` (k, dof) are proven to keep; or 0."""
    if wanted <= 0 or len(path) < 2:
        return 0.0
    start, delta = path[:-1], np.diff(path, axis=0)
    for clearance in halves(wanted):
        if EdgeProver(with_extra_margin(checker, clearance)).free(start, delta).all():
            return clearance
    return 0.0


def halves(wanted: float) -> list[float]:
    """``wanted``, half of it, and so on."""
    return [wanted * 0.5**k for k in range(_HALVES)]
