"""The roadmap of a request: grown around its ends, or loaded, proven again and linked to them."""

import logging
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from planner.base.arrays import Bools, Ints
from planner.base.errors import FileError, choices, log_notes
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker, is_free
from planner.collision.edge_prover import EdgeProver
from planner.problem.request import PAPER_NODES, PlanQuality, RoadmapQuality, SweepQuality
from planner.query.query import Query
from planner.query.resolve import clip_to_limits
from planner.roadmap.connect_endpoints import attach
from planner.roadmap.measure import check_nodes, measure_roadmap
from planner.roadmap.roadmap import Roadmap, edge_motions, record_origin, restrict_to_constraints
from planner.roadmap.storage import load_roadmap, same_world
from planner.robot.robot import Robot

_log = logging.getLogger(__name__)

_FEWEST_NODES = 2  # a path alone: the nodes of the first paths, without links


def load_or_build_roadmap(quality: RoadmapQuality, query: Query, progress: Progress = QUIET) -> Roadmap:
    """Return a roadmap with the query's starts and goals: grown, or loaded and proven again where needed.

    With ``path_only`` nothing grows around the first path. Raises :class:`PlannerError` for a roadmap of other joints.
    """
    file = quality.roadmap if isinstance(quality, SweepQuality) else None
    if file is None:
        from planner.roadmap.build import DENSITY, roadmap_between  # with all that grows roadmaps, and OMPL
        from planner.roadmap.grow import GrowthSettings

        robot = query.robot
        starts, goals = (robot.normalise(clip_to_limits(robot, ends)) for ends in (query.starts, query.goals))
        growth = GrowthSettings(floor=quality.min_manipulability)
        path_only = isinstance(quality, PlanQuality) and quality.path_only
        nodes, density = (_FEWEST_NODES, 0.0) if path_only else (quality.nodes, DENSITY)
        return roadmap_between(query.checker, starts, goals, nodes, quality.seed, growth, density, progress=progress)
    roadmap = load_roadmap(file)
    if quality.nodes not in (PAPER_NODES, len(roadmap.nodes)):
        _log.warning(
            "%s has %d nodes, and none grow: --nodes is not followed.",
            file,
            len(roadmap.nodes),
        )
    roadmap = reprove_in_other_world(roadmap, query.checker, progress)
    roadmap = restrict_to_constraints(roadmap, query.checker.world.constraints)
    roadmap = check_nodes(roadmap, query.checker)
    return attach(roadmap, query.checker, query.starts, query.goals, quality.seed, progress=progress)


_BATCH = 128  # edges proven between two checks for a stop
_LIMIT_SLACK = 1e-9  # rad: forgives a limit that was printed and read back


def reprove_in_other_world(roadmap: Roadmap, checker: CollisionChecker, progress: Progress = QUIET) -> Roadmap:
    """Return the roadmap if it was proven in the checker's world, else what holds there, with a message.

    Raises :class:`FileError` as :func:`reprove` does.
    """
    if same_world(roadmap, checker):
        return roadmap
    part = reprove(roadmap, checker, progress)
    origin, count = roadmap.origin, f"{len(part.edges)} of {len(roadmap.edges)}"
    log_notes(
        f"the roadmap was proven for another state of '{origin.robot}' in scene '{origin.scene}': "
        f"all edges are proven again, {count} hold"
    )
    return part


def reprove(roadmap: Roadmap, checker: CollisionChecker, progress: Progress = QUIET) -> Roadmap:
    """Return the free nodes within limits and the edges between them that are proven free, measured again.

    A stop of ``progress`` drops the remaining edges as unproven. Raises :class:`FileError` where the joints differ, or
    no node is left.
    """
    robot, m = checker.robot, len(roadmap.edges)
    if roadmap.origin.joints != robot.joints:
        raise FileError(
            f"the roadmap is for joints {choices(roadmap.origin.joints)}, the robot has {choices(robot.joints)}: "
            "build one for this robot."
        )
    prover, free, clearance, samples = EdgeProver(checker, progress), np.zeros(m, bool), np.zeros(m), np.zeros(m, int)
    for rows in batches(np.arange(m)):
        if progress.stopped:
            break
        proofs = prover.prove(*edge_motions(roadmap, robot, rows))
        free[rows], clearance[rows], samples[rows] = proofs.free, proofs.clearance, proofs.samples
        progress("edges", int(rows[-1]) + 1, m)
    nodes = _usable_nodes(roadmap, checker, free)
    whole = replace(
        roadmap,
        checked_by=np.zeros(len(roadmap.nodes), dtype=np.int8),
        proven=free,
        clearance=np.maximum(clearance, 0.0),
        samples=samples,
        origin=record_origin(checker, roadmap.origin.seed),
    )
    part = check_nodes(whole.part(nodes, free), checker)
    w, scale, measures = measure_roadmap(robot, part.nodes, part.edges)
    return replace(part, manipulability=w, scale=scale, **measures)


def batches(rows: Ints) -> Iterator[Ints]:
    """Yield ``rows`` a few at a time, so that the work can stop between them."""
    for first in range(0, len(rows), _BATCH):
        yield rows[first : first + _BATCH]


def _usable_nodes(roadmap: Roadmap, checker: CollisionChecker, proven: Bools) -> Bools:
    """Return (n,) which nodes are within limits and free; the ends of a proven edge are free."""
    good, ends = _within_limits(roadmap, checker.robot), np.zeros(len(roadmap.nodes), dtype=bool)
    ends[roadmap.edges[proven]] = True
    for row in np.flatnonzero(good & ~ends):
        good[row] = is_free(checker, roadmap.nodes[row])
    if not good.any():
        raise FileError("no node of the roadmap is free in this scene: build a new roadmap.")
    return good


def _within_limits(roadmap: Roadmap, robot: Robot) -> Bools:
    """Return (n,) which nodes are within the robot's limits; a continuous joint has none."""
    beyond = np.maximum(robot.lower - roadmap.nodes, roadmap.nodes - robot.upper)
    return np.where(robot.continuous, 0.0, beyond).max(axis=1) <= _LIMIT_SLACK
