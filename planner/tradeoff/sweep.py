"""The exact trade-off: every path that is optimal at some beta on one roadmap, with its betas."""

from dataclasses import replace
from typing import Any

from planner.base.progress import QUIET, Progress, Stopwatch
from planner.planning.improvement import improve_for_all_betas
from planner.planning.result import Plan
from planner.planning.solve import time_plan
from planner.problem.options import ROBOT, SCENE, RobotLike, SceneLike
from planner.problem.outcome import Outcome
from planner.problem.request import Objective, PlanRequest, SweepRequest, TimingRequest, build_request
from planner.query.query import make_query
from planner.roadmap.load_or_build import load_or_build_roadmap
from planner.roadmap.roadmap import path_waypoints
from planner.search.manipulability_floor import LayeredNetwork
from planner.search.search import RoadmapPaths
from planner.tradeoff.envelope import EnvelopeSearch, find_knee, support_intervals
from planner.tradeoff.result import Interval, Tradeoff, add_intervals, interval_numbers
from planner.trajectory.limits import MotionLimits
from planner.view.motion import ShownPath, path_rows


def sweep(
    robot: RobotLike = ROBOT,
    scene: SceneLike = SCENE,
    *,
    request: SweepRequest | PlanRequest | None = None,
    timing: TimingRequest | None = TimingRequest(),  # noqa: B008 (frozen)
    objective: Objective | None = None,
    progress: Progress = QUIET,
    **options: Any,
) -> Tradeoff:
    """Return the whole trade-off between manipulability and distance, on one roadmap.

        sweep("panda", "shelf", seed=3).at(0.2)

    ``options`` are those of :class:`SweepRequest`, all else is as in :func:`planner.plan`; an objective's beta stays
    its default. Every path is checked again at every 1 mm of motion, as a plan's is; a path that fails is removed and
    the sweep restarts. Each becomes a motion in ``timing``, for the beta in the middle of its interval; with None it
    stays a path. ``progress`` is called with (stage, done, total), for stage "beta" with the settled per cent of [0,
    1]; once a stop is requested the sweep ends soon and returns the proven intervals, with ``Outcome.INTERRUPTED``.
    Raises :class:`PlannerError` for unusable input.
    """
    request = build_request(request or SweepRequest(), objective, options, robot, scene)
    clock = Stopwatch()
    with clock("setup"):
        query = make_query(request.what, progress=progress)
        limits = None if timing is None else MotionLimits.from_robot(query.robot, timing)
    with clock("roadmap"):
        roadmap = load_or_build_roadmap(request.quality, query, progress)
    with clock("improve"):
        roadmap, clearance, _ = improve_for_all_betas(roadmap, query.checker, request.quality, progress)
    begun = {"clearance": clearance, "end_notes": query.end_notes}
    result = Tradeoff(request, Outcome.INTERRUPTED, query.checker, roadmap, **begun)
    if not progress.stopped:
        result = add_intervals(result, clock, progress)
    intervals = [replace(item, goal=query.goal_at(item.path[-1])) for item in result.intervals]
    for k, item in enumerate(intervals):
        if progress.stopped:
            result = replace(result, outcome=Outcome.INTERRUPTED)
            break
        plan = result.plan_along(item, item.beta)
        if timing is not None:
            with clock("timing"):
                plan = replace(plan, trajectory=time_plan(plan, timing, limits))
        with clock("measures"):
            intervals[k] = _add_motion(item, plan)
        progress("timing", k + 1, len(intervals))
    return replace(result, intervals=tuple(intervals), timings=clock.seconds)


def _add_motion(item: Interval, plan: Plan) -> Interval:
    """Return the interval with the motion of a plan along its path, its duration and smallest clearance."""
    motion, near = plan.trajectory, plan.clearance
    assert near is not None  # there is a path
    least = min((each.min for each in (near.path, near.motion) if each is not None), default=None)
    return replace(item, trajectory=motion, duration=None if motion is None else motion.duration, clearance=least)


def add_alternatives(plan: Plan, progress: Progress = QUIET) -> Plan:
    """Return the plan with the paths of every other beta on its network, for its page.

    One path for every interval of beta, sorted; none if the search was stopped. They consist of proven edges and stay
    above the plan's floor, without a second check. Their fields are the oracle's. Where obstacles move there are none:
    no beta chooses among motions in time.
    """
    if plan.layered is None or plan.cost is None or plan.scene.moving:
        return plan
    clock = Stopwatch()
    with clock("alternatives"):
        alternatives = _paths_for_every_beta(plan, plan.layered, progress)
    return replace(plan, alternatives=alternatives, timings=plan.timings | clock.seconds)


def _paths_for_every_beta(plan: Plan, layered: LayeredNetwork, progress: Progress) -> tuple[ShownPath, ...]:
    floor = plan.request.quality.min_manipulability
    search = EnvelopeSearch(RoadmapPaths(plan.roadmap, plan.robot, layered, floor, lambda nodes: nodes[:0]))
    while not search.is_done:
        if progress.stopped:
            return ()
        search.step()
        progress("other betas", int(100 * search.reach), 100)
    known = support_intervals(search.supports)
    paths = [path_waypoints(plan.roadmap, plan.robot, layered.roadmap_node[piece.support.nodes]) for piece in known]
    numbers = interval_numbers(known, paths, plan.robot, complete=True)
    knee = find_knee([(item.gain, item.added_length) for item in numbers])
    shown = []
    for k, (item, piece, path) in enumerate(zip(numbers, known, paths, strict=True)):
        costs = item.manipulability_cost, item.distance_cost
        rows, field = path_rows(plan.robot, path, *costs), layered.on_roadmap(piece.support.x)
        betas = item.beta_min, item.beta_max
        shown.append(ShownPath(path, rows, betas, field, costs, choice=item.choice(k == knee)))
    return tuple(shown)
