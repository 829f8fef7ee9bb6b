"""The roadmap that a request names: loaded and linked to the query's ends, or grown around them."""

from __future__ import annotations

import logging

from planner.base.progress import QUIET, Progress
from planner.construction.connect_endpoints import attach
from planner.problem.request import PAPER_NODES, SweepRequest
from planner.roadmap.node_checks import with_checked_nodes
from planner.roadmap.roadmap import Roadmap, kept_part
from planner.roadmap.storage import load_roadmap, require_same_world
from planner.setup.open import Query

_log = logging.getLogger(__name__)

_FEWEST_NODES = 2  # those of the first paths, and no links: they pass no states that they need not


def obtain_roadmap(request: SweepRequest, query: Query, progress: Progress = QUIET, path_only: bool = False) -> Roadmap:
    """A roadmap whose starts and goals are the query's; with ``path_only`` nothing grows around the first paths.

    Raises :class:`PlannerError` for a file of another world.
    """
    if request.roadmap is None:
        from planner.construction.build import DENSITY, build_roadmap  # with all that grows roadmaps, and OMPL

        return build_roadmap(
            query.robot,
            query.checker,
            query.starts,
            query.goals,
            _FEWEST_NODES if path_only else request.nodes,
            request.seed,
            progress,
            request.min_manipulability,
            0.0 if path_only else DENSITY,
        )
    roadmap = load_roadmap(request.roadmap)
    if request.nodes not in (PAPER_NODES, len(roadmap.nodes)):
        _log.warning(
            "%s has %d nodes, and none grow: --nodes is not followed; 'planner roadmap extend' adds some.",
            request.roadmap,
            len(roadmap.nodes),
        )
    require_same_world(roadmap, query.checker, request.roadmap)
    roadmap = kept_part(roadmap, query.checker.world.keeps)
    roadmap = with_checked_nodes(roadmap, query.checker)
    return attach(roadmap, query.checker, query.starts, query.goals, request.seed, progress=progress)
