"""Improve a roadmap for a request: refine its best path, search others, and add them."""

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
from planner.roadmap.improve import Improvement, drop_last_nodes, improve
from planner.roadmap.roadmap import Roadmap, edge_motions, path_waypoints
from planner.search.manipulability_floor import build_layers
from planner.search.network import build_network, cheapest_steps
from planner.trajectory.measure import path_manipulability

_ROUNDS_WITHOUT_DIP = 2
IMPROVED_AT = (0.5, 0.0, 1.0)  # betas at which plans and sweeps improve a roadmap
_SEEDS_APART = 1000  # distinct seeds, so no stage repeats the trials of the previous one
_HALVES = 6  # from 5 mm to 0.16 mm, the resolution of proofs
_ROUNDING = 1e-9  # relative, of w at one state computed from either end of an edge


def improve_plan(draft: Plan, progress: Progress) -> Plan:
    """Return the plan on an improved roadmap; a new roadmap has the requested number of nodes.

    The roadmap of a sweep, improved further at the plan's own beta: its path costs at most as much as the sweep's.
    """
    quality, checker = draft.request.quality, draft.checker
    roadmap, clearance, curves = improve_for_all_betas(draft.roadmap, checker, quality, progress, quality.beta)
    if quality.beta == 0.0 and quality.min_manipulability <= 0:
        roadmap = add_path_without_dip(roadmap, checker, quality, progress, clearance)
    if quality.roadmap is None:
        roadmap = trim_roadmap(roadmap, len(draft.roadmap.nodes), quality, clearance)
    return replace(draft, roadmap=roadmap, curve=curves.get(quality.beta, ()), clearance_kept=clearance)


def improve_for_all_betas(
    roadmap: Roadmap,
    checker: CollisionChecker,
    quality: SweepQuality,
    progress: Progress = QUIET,
    own: float = IMPROVED_AT[0],
) -> tuple[Roadmap, float, dict[float, Curve]]:
    """Return the roadmap improved at ``IMPROVED_AT`` and ``own``, its clearance (m), and cost curves.

    Each beta has half the rounds. Without rounds, a saved roadmap stays unchanged.
    """
    if quality.roadmap is not None and quality.rounds < 1:
        return roadmap, 0.0, {}
    (roadmap, clearance), curves = certify_clearance(roadmap, checker, quality, progress), dict[float, Curve]()
    betas = IMPROVED_AT if own == IMPROVED_AT[0] else (*IMPROVED_AT, own)
    for k, beta in enumerate(betas):
        seed = (quality.seed + _SEEDS_APART * k) % 2**31
        half = replace(quality, refinement_rounds=-(-quality.rounds // 2), seed=seed)
        overall = progress.with_report(lambda *of, k=k: progress(of[0], k * of[2] + of[1], len(betas) * of[2]))
        improvement = improve_roadmap(roadmap, checker, half, beta, overall, clearance)
        roadmap, curves[beta] = improvement.roadmap, improvement.curve
    return roadmap, clearance, curves


def certify_clearance(
    roadmap: Roadmap, checker: CollisionChecker, quality: SweepQuality, progress: Progress = QUIET
) -> tuple[Roadmap, float]:
    """Return the roadmap with new certificates, and the clearance (m) of its paths beyond the margin.

    The clearance is the largest of ``quality.extra_clearance``, its half, a quarter, ... at which edges connect a start
    and a goal, above the floor if there is one; else 0. Short and well-conditioned paths graze obstacles, so all edges
    of the plan's network, trials of refinement and shortcuts in time keep this clearance.
    """

    def is_connected_at(clearance: float) -> bool:
        if quality.min_manipulability > 0:
            return len(_best_nodes(roadmap, quality, 1.0, clearance)) > 0
        edges, begin = roadmap.edges[roadmap.clearance >= clearance], np.zeros(len(roadmap.nodes), dtype=bool)
        begin[roadmap.starts] = True
        return bool(reachable(begin, np.concatenate([edges, edges[:, ::-1]]))[roadmap.goals].any())

    if quality.extra_clearance <= 0 or not is_connected_at(0.0):
        return roadmap, 0.0
    for clearance in halves(quality.extra_clearance):
        roadmap = _with_proofs(roadmap, checker, clearance, progress)
        if progress.stopped:
            break
        if is_connected_at(clearance):
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
    """Improve the best path by :func:`planner.roadmap.improve.improve` at ``beta``.

    All paths keep ``clearance`` (m) beyond the margin. With a floor, the section of the path above the floor is
    improved and stays above. The roadmap is unchanged if it has no such path.
    """
    if quality.rounds < 1 or progress.stopped:
        return Improvement(roadmap)
    path = path_waypoints(roadmap, checker.robot, _best_nodes(roadmap, quality, beta, clearance))
    above = np.flatnonzero(manipulability(checker.robot, path) >= quality.min_manipulability)
    if len(above) < 2:
        return Improvement(roadmap)
    cost = motion_cost(roadmap, checker, quality, beta)
    section, wider = path[above[0] : above[-1] + 1], with_extra_margin(checker, clearance)
    return improve(roadmap, wider, cost, section, quality.rounds, quality.seed, progress, clearance=clearance)


def add_path_without_dip(
    roadmap: Roadmap,
    checker: CollisionChecker,
    quality: PlanQuality,
    progress: Progress = QUIET,
    clearance: float = 0.0,
) -> Roadmap:
    """Return the roadmap with a path whose w is never below that of both ends, if one is found."""
    path = path_waypoints(roadmap, checker.robot, _best_nodes(roadmap, quality, quality.beta, clearance))
    rounds = min(quality.rounds, _ROUNDS_WITHOUT_DIP)
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
    """Return the cost function of motions at ``beta``, as the network of ``roadmap`` has it."""
    return MotionCost(checker.robot, roadmap.scale, quality.objective_at(beta))


def trim_roadmap(roadmap: Roadmap, grown: int, quality: PlanQuality, clearance: float = 0.0) -> Roadmap:
    """Return an improved roadmap with the requested number of nodes; its first ``grown`` were grown."""
    if len(roadmap.nodes) <= quality.nodes:
        return roadmap
    best = _best_nodes(roadmap, quality, quality.beta, clearance)
    return drop_last_nodes(roadmap, grown, quality.nodes, best)


def _best_nodes(roadmap: Roadmap, quality: SweepQuality, beta: float, clearance: float) -> Ints:
    """Return the nodes (k,) of the best path at ``beta`` that keeps ``clearance`` (m) and the floor."""
    network = build_network(roadmap, quality.objective_at(beta), clearance)
    layered = build_layers(roadmap, network, quality.min_manipulability)
    return layered.roadmap_node[cheapest_steps(layered.network, layered.starts)]


def _with_proofs(roadmap: Roadmap, checker: CollisionChecker, clearance: float, progress: Progress) -> Roadmap:
    """Prove ``clearance`` (m) of edges with smaller certificates; return the roadmap."""
    rows = np.flatnonzero(roadmap.clearance < clearance)
    wider = with_extra_margin(checker, clearance)
    prover = EdgeProver(wider, progress, "clearance")
    proofs = prover.prove(*edge_motions(roadmap, checker.robot, rows), contacts=False)
    known, free = roadmap.clearance.copy(), proofs.free
    known[rows[free]] = clearance + np.maximum(proofs.clearance[free], 0.0)
    return replace(roadmap, clearance=known)


def prove_path_clearance(path: Floats, checker: CollisionChecker, largest: float) -> float:
    """Return the largest of ``largest``, its half, ... (m) that is proven of a ``path`` (k, dof); or 0."""
    if largest <= 0 or len(path) < 2:
        return 0.0
    start, delta = path[:-1], np.diff(path, axis=0)
    for clearance in halves(largest):
        if EdgeProver(with_extra_margin(checker, clearance)).free(start, delta).all():
            return clearance
    return 0.0


def halves(largest: float) -> list[float]:
    """Return ``largest``, half of it, a quarter, and so on."""
    return [largest * 0.5**k for k in range(_HALVES)]
