"""One plan, as in the paper: roadmap, costs, dynamics, path and motion. Read this file first."""

from dataclasses import replace
from typing import Any

from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.planning.improvement import improve_plan
from planner.planning.legs import find_legs
from planner.planning.result import Plan
from planner.planning.solve import require_earliest, solve
from planner.problem.options import ROBOT, SCENE, RobotLike, SceneLike
from planner.problem.outcome import CannotFollow, Outcome
from planner.problem.request import Objective, PlanRequest, TimingRequest, build_request
from planner.query.query import make_query
from planner.roadmap.load_or_build import load_or_build_roadmap
from planner.tool_paths.ladder_roadmap import roadmap_of_nodes
from planner.trajectory.limits import MotionLimits


def plan(
    robot: RobotLike = ROBOT,
    scene: SceneLike = SCENE,
    *,
    request: PlanRequest | None = None,
    timing: TimingRequest | None = TimingRequest(),  # noqa: B008 (frozen)
    objective: Objective | None = None,
    progress: Progress = QUIET,
    **options: Any,
) -> Plan:
    """Plan as in the paper: RRT roadmap, costs, GABF for the cost-to-go, minimising neighbours.

        plan("panda", "shelf", beta=0.2).trajectory
        plan(request=PlanRequest.from_options(seed=3), nodes=200)
        plan("ur5", objective=Objective(beta=0.2, metric="workspace"), timing=None)

    ``options`` are fields of :class:`PlanRequest`. They, ``robot``, ``scene`` and ``objective`` replace those of
    ``request``. ``timing`` sets how the path becomes a motion, see :func:`planner.trajectory.timing.time_path`; None
    returns the path only. The planner calls ``progress`` with (stage, done, total). When ``progress`` requests a stop,
    planning stops soon after and returns the partial plan, with ``Outcome.INTERRUPTED``. Raises :class:`PlannerError`
    for unusable input and :class:`KeywordError` for unknown options.

    If obstacles move along known motions, the plan is the earliest collision-free motion through the roadmap, with
    waits; ``beta`` then shapes the roadmap only, and ``timing`` is required.
    """
    clock = Stopwatch()
    request = build_request(request or PlanRequest(), objective, options, robot, scene)
    if request.what.in_turn:
        raise OptionError("in_turn must be False for planner.plan, got True: give the cell to planner.CellPlanner.")
    with clock("setup"):
        query = make_query(request.what, in_time=timing is not None, progress=progress)
        limits = None if timing is None else MotionLimits.from_robot(query.robot, timing)
        if query.scene.moving:
            require_earliest(request, timing)
        legs = find_legs(query, request)
    shared: dict[str, Any] = {"checker": query.checker, "timings": clock.seconds, "end_notes": query.end_notes}
    if isinstance(legs, CannotFollow):
        ends_only = roadmap_of_nodes(query.checker, query.ends, request.quality.seed)
        return Plan(request, Outcome.NO_PATH, roadmap=ends_only, reason=legs, **shared)
    with clock("roadmap"):
        roadmap = load_or_build_roadmap(request.quality, legs.query_between(query), progress)
    draft = Plan(request, Outcome.INTERRUPTED, roadmap=roadmap, **shared)
    with clock("improve"):
        improved = draft if progress.stopped else legs.attach(improve_plan(draft, progress))
    solved = draft if progress.stopped else solve(improved, limits, progress, clock)
    if not solved.solved:
        return draft if solved.outcome is Outcome.INTERRUPTED else solved
    solved = replace(solved, goal=query.goal_at(solved.path[-1]), legs=legs.make_records(query.robot, solved.path))
    if timing is None or solved.trajectory is not None:
        return solved
    with clock("timing"):
        return legs.time(solved, timing, limits)
