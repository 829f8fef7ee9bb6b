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
from planner.roadmap.measure import check_nodes, measure_roadmap, unchecked
from planner.roadmap.roadmap import Roadmap, record_origin
from planner.roadmap.shortcuts import add_refined_paths
from planner.robot.robot import Robot

_REST = 1_000_003  # added to the seed where the tree goes on: with the same seed it would draw the same samples again


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
    """A roadmap of proven edges between configurations ``start`` and ``goal`` ((dof,) or (k, dof), rad).

    By counts: a first path, RRT around it, links until there are ``density`` edges per node (more: more choice and
    more proofs), refined best paths, RRT again. ``refined`` is the share of the ``nodes`` that is kept for the refined
    paths. With ``min_manipulability`` it grows above that w, but for the paths up to it from a start or goal below.
    Raises :class:`StateError` where one of them is out of limits or in collision.
    """
    if robot is not checker.robot:
        raise OptionError("the checker was made for another robot: make one with make_checker(robot, scene).")
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
    """As :func:`build_roadmap`, between ``starts`` (s, dof) and ``goals`` (g, dof) that are known to be free."""
    prover = RecordingProver(checker, progress)
    totals = {ROADMAP: nodes, LINKS: round(density * nodes)}  # both grow in two parts
    whole = progress.with_report(lambda stage, done, total: progress(stage, done, totals.get(stage, total)))

    def link(configurations: Floats, edges: Ints) -> Ints:
        return connect(prover, configurations, edges, round(density * len(configurations)), whole)

    kept = round(refined * nodes)
    grown = grow(prover, starts, goals, nodes - kept, seed, growth, whole)
    configurations, edges = grown.nodes, link(grown.nodes, grown.edges)
    if kept and not progress.stopped:
        ends = grown.starts, grown.goals
        configurations, edges = add_refined_paths(
            prover, configurations, edges, *ends, kept, growth.floor, seed, progress
        )
        # what the refined paths left of their share goes to the tree
        rest = grow(prover, configurations, goals[:0], nodes, seed + _REST, growth, whole)
        configurations, edges = rest.nodes, link(rest.nodes, np.concatenate([edges, rest.edges]))
    for stage, count in ((ROADMAP, len(configurations)), (LINKS, len(edges))):
        progress(stage, count, count)
    return _measured(prover, configurations, edges, grown.starts, grown.goals, seed)


def _require_shares(density: float, refined: float) -> None:
    if not (0.0 <= density < np.inf and 0.0 <= refined < 1.0):
        raise OptionError(
            f"a density of {density:g} edges per node and a share of {refined:g} for refined paths are not usable: "
            "give 0 or more, and below 1 for the share."
        )


def _ends(
    start: Floats | Sequence[float], goal: Floats | Sequence[float], checker: CollisionChecker
) -> tuple[Floats, Floats]:
    """Starts (s, dof) and goals (g, dof) that are free."""
    ends = [(role, _rows(role, given)) for role, given in (("start", start), ("goal", goal))]
    free = free_configurations([(role, q) for role, values in ends for q in values], checker)
    first = len(ends[0][1])
    return free[:first], free[first:]


def _rows(role: str, given: Floats | Sequence[float]) -> Floats:
    """Configurations (k, dof), one at least."""
    values = numbers(role, np.atleast_2d(plain_numbers(role, given, StateError)), ("k", "dof"), StateError)
    if not len(values):
        raise StateError(f"there is no {role}: give at least one configuration.")
    return values


def _measured(prover: RecordingProver, nodes: Floats, edges: Ints, starts: Ints, goals: Ints, seed: int) -> Roadmap:
    """The roadmap of proven ``edges`` (m, 2), sorted, with what its costs are made of, and its certificates."""
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
        checked_by=unchecked(len(nodes)),
        scale=scale,
        origin=record_origin(prover.checker, seed),
    )
    return check_nodes(roadmap, prover.checker)
