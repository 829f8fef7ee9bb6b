"""The roadmap that a request names: loaded and linked to the query's ends, or grown around them."""

from __future__ import annotations

import logging

from planner.base.progress import QUIET, Progress
from planner.problem.request import PAPER_NODES, PlanQuality, RoadmapQuality, SweepQuality
from planner.query.query import Query
from planner.query.resolve import brought_within
from planner.roadmap.connect_endpoints import attach
from planner.roadmap.node_checks import with_checked_nodes
from planner.roadmap.reprove import in_this_world
from planner.roadmap.roadmap import Roadmap, kept_part
from planner.roadmap.storage import load_roadmap

_log = logging.getLogger(__name__)

_FEWEST_NODES = 2  # those of the first paths, and no links: they pass no states that they need not


def obtain_roadmap(quality: RoadmapQuality, query: Query, progress: Progress = QUIET) -> Roadmap:
    """A roadmap whose starts and goals are the query's: kept, or grown; of a path only nothing grows around it.

    A roadmap from a file is used as far as it holds in this world. Raises
    :class:`PlannerError` for one of other joints.
    """
    kept = quality.roadmap if isinstance(quality, SweepQuality) else None
    if kept is None:
        from planner.roadmap.build import DENSITY, roadmap_between  # with all that grows roadmaps, and OMPL
        from planner.roadmap.growth_settings import GrowthSettings

        robot = query.robot
        starts, goals = (robot.normalise(brought_within(robot, ends)) for ends in (query.starts, query.goals))
        growth = GrowthSettings(floor=quality.min_manipulability)
        path_only = isinstance(quality, PlanQuality) and quality.path_only
        nodes, density = (_FEWEST_NODES, 0.0) if path_only else (quality.nodes, DENSITY)
        return roadmap_between(query.checker, starts, goals, nodes, quality.seed, growth, density, progress=progress)
    roadmap = load_roadmap(kept)
    if quality.nodes not in (PAPER_NODES, len(roadmap.nodes)):
        _log.warning(
            "%s has %d nodes, and none grow: --nodes is not followed.",
            kept,
            len(roadmap.nodes),
        )
    roadmap = in_this_world(roadmap, query.checker, progress)
    roadmap = kept_part(roadmap, query.checker.world.keeps)
    roadmap = with_checked_nodes(roadmap, query.checker)
    return attach(roadmap, query.checker, query.starts, query.goals, quality.seed, progress=progress)
