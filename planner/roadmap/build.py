"""A new roadmap: grow a tree, link neighbours, refine the best paths, measure."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from planner.base.arrays import Floats, Ints, numbers, plain_numbers
from planner.base.errors import OptionError, StateError
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.problem.options import PAPER_EDGES, PAPER_NODES
from planner.problem.request import RoadmapQuality
from planner.query.resolve import free_configurations
from planner.roadmap.connections import LINKS, connect
from planner.roadmap.edges import RecordingProver
from planner.roadmap.grow import ROADMAP, GrowthSettings, grow
from planner.roadmap.measure import check_nodes, measure_roadmap
from planner.roadmap.roadmap import Roadmap, record_origin
from planner.roadmap.shortcuts import add_refined_paths
from planner.robot.robot import Robot

_REST = 1_000_003  # added to the seed where the tree continues, which must not draw the same samples
DENSITY = PAPER_EDGES / PAPER_NODES  # edges per node
REFINED = 0.1  # share of the nodes


def build_roadmap(
    robot: Robot,
    checker: CollisionChecker,
    start: Floats | Sequence[float],
    goal: Floats | Sequence[float],
    nodes: int = PAPER_NODES,
    seed: int = 0,
    progress: Progress = QUIET,
    min_manipulability: float = 0.0,
    density: float = DENSITY,
    refined: float = REFINED,
    growth: GrowthSettings | None = None,
) -> Roadmap:
    """Return a roadmap of proven edges between configurations ``start`` and ``goal``, (dof,) or (k, dof).

    In order: a first path, RRT around it, links until there are ``density`` edges per node (more: more choice and more
    proofs), refined best paths, RRT again. ``refined`` is the share of the ``nodes`` for the refined paths. With
    ``min_manipulability`` it grows above that w, except for paths up to it from a start or goal below. Raises
    :class:`StateError` where a start or goal is out of limits or in collision.
    """
    if robot is not checker.robot:
        raise OptionError("the checker must be for the same robot: make one with make_checker(robot, scene).")
    RoadmapQuality(nodes, seed, min_manipulability)  # refuses what is out of range
    _require_shares(density, refined)
    growth = replace(growth or GrowthSettings(), floor=min_manipulability)
    return roadmap_between(checker, *_ends(start, goal, checker), nodes, seed, growth, density, refined, progress)


def roadmap_between(
    checker: CollisionChecker,
    starts: Floats,
    goals: Floats,
    nodes: int,
    seed: int,
    growth: GrowthSettings,
    density: float = DENSITY,
    refined: float = REFINED,
    progress: Progress = QUIET,
) -> Roadmap:
    """Return a roadmap as :func:`build_roadmap`, between free ``starts`` (s, dof) and ``goals`` (g, dof)."""
    prover = RecordingProver(checker, progress)
    totals = {ROADMAP: nodes, LINKS: round(density * nodes)}  # both grow twice
    whole = progress.with_report(lambda stage, done, total: progress(stage, done, totals.get(stage, total)))

    def link(configurations: Floats, edges: Ints) -> Ints:
        return connect(prover, configurations, edges, round(density * len(configurations)), whole)

    reserved = round(refined * nodes)
    grown = grow(prover, starts, goals, nodes - reserved, seed, growth, whole)
    configurations, edges = grown.nodes, link(grown.nodes, grown.edges)
    if reserved and not progress.stopped:
        ends = grown.starts, grown.goals
        configurations, edges = add_refined_paths(
            prover, configurations, edges, *ends, reserved, growth.floor, seed, progress
        )
        # the tree gets the unused share of the refined paths
        rest = grow(prover, configurations, goals[:0], nodes, seed + _REST, growth, whole)
        configurations, edges = rest.nodes, link(rest.nodes, np.concatenate([edges, rest.edges]))
    for stage, count in ((ROADMAP, len(configurations)), (LINKS, len(edges))):
        progress(stage, count, count)
    return _measure(prover, configurations, edges, grown.starts, grown.goals, seed)


def roadmap_of_path(checker: CollisionChecker, path: Floats, seed: int) -> Roadmap:
    """Return the roadmap that is a proven path (k, dof): its waypoints, and the motions between them."""
    last = np.array([len(path) - 1])
    edges = np.stack([np.arange(len(path) - 1), np.arange(1, len(path))], axis=1)
    return _measure(RecordingProver(checker), path, edges, 0 * last, last, seed)


def _require_shares(density: float, refined: float) -> None:
    if not (0.0 <= density < np.inf and 0.0 <= refined < 1.0):
        raise OptionError(
            f"density must be at least 0 and refined from 0 to below 1, got {density:g} edges per node and {refined:g}."
        )


def _ends(
    start: Floats | Sequence[float], goal: Floats | Sequence[float], checker: CollisionChecker
) -> tuple[Floats, Floats]:
    """Return free starts (s, dof) and goals (g, dof)."""
    ends = [(role, _rows(role, given)) for role, given in (("start", start), ("goal", goal))]
    free = free_configurations([(role, q) for role, values in ends for q in values], checker)
    first = len(ends[0][1])
    return free[:first], free[first:]


def _rows(role: str, given: Floats | Sequence[float]) -> Floats:
    """Return configurations (k, dof), k at least 1."""
    values = numbers(role, np.atleast_2d(plain_numbers(role, given, StateError)), ("k", "dof"), StateError)
    if not len(values):
        raise StateError(f"{role} must not be empty: give at least one configuration.")
    return values


def _measure(prover: RecordingProver, nodes: Floats, edges: Ints, starts: Ints, goals: Ints, seed: int) -> Roadmap:
    """Return the roadmap of proven ``edges`` (m, 2), sorted, with its measures and certificates."""
    robot = prover.robot
    edges = edges[np.lexsort((edges[:, 1], edges[:, 0]))]
    w, scale, measures = measure_roadmap(robot, nodes, edges)
    clearance, samples = prover.certificates(nodes, edges)
    roadmap = Roadmap(
        nodes=nodes,
        edges=edges,
        proven=np.ones(len(edges), dtype=bool),
        starts=starts,
        goals=goals,
        manipulability=w,
        **measures,
        clearance=clearance,
        samples=samples,
        checked_by=np.zeros(len(nodes), dtype=np.int8),
        scale=scale,
        origin=record_origin(prover.checker, seed),
    )
    return check_nodes(roadmap, prover.checker)
