"""The roadmap that a request names: loaded and linked to the query's ends, or grown around them."""

from __future__ import annotations

from planner.base.progress import QUIET, Progress
from planner.base.request import SweepRequest
from planner.query.open import Query
from planner.roadmap.attach import attach
from planner.roadmap.build import build_roadmap
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import load_roadmap, require_same_world


def obtain_roadmap(request: SweepRequest, query: Query, progress: Progress = QUIET) -> Roadmap:
    """A roadmap whose starts and goals are the query's. Raises :class:`PlannerError` for a file of another world."""
    if request.roadmap is None:
        return build_roadmap(
            query.robot,
            query.checker,
            query.starts,
            query.goals,
            request.nodes,
            request.seed,
            progress,
            request.min_manipulability,
        )
    roadmap = load_roadmap(request.roadmap)
    require_same_world(roadmap, query.checker, request.roadmap)
    return attach(roadmap, query.checker, query.starts, query.goals, request.seed, progress=progress)
