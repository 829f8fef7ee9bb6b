"""Follow a tool path: a ladder of proven motions as a roadmap, its field, and the free motion to it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planner import gabf
from planner.base.arrays import Floats
from planner.base.errors import OptionError, SceneError
from planner.base.files import StrPath
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.planning.improvement import improve_plan
from planner.planning.result import Plan
from planner.planning.solve import recheck, solve_and_heal, time_plan, why_no_path
from planner.problem.options import ROBOT, SCENE, RobotLike, SceneLike
from planner.problem.outcome import CannotFollow, Outcome
from planner.problem.request import FollowRequest, Objective, TimingRequest, build_request
from planner.query.query import Query, make_checker_for, states_of
from planner.query.resolve import other_turns, resolve
from planner.roadmap.load_or_build import load_or_build_roadmap
from planner.roadmap.roadmap import Roadmap, try_min_clearance
from planner.search.manipulability_floor import highest_floor
from planner.search.network import build_network
from planner.tool_paths.file import read_tool_path
from planner.tool_paths.ladder import build_ladder
from planner.tool_paths.ladder_roadmap import LEFT_OUT, NEW, LadderProgress, attach_ladder, explain_stop, follow_ladder
from planner.tool_paths.tool_motion import (
    FollowedPath,
    ToolPathRecord,
    ToolSpeedRecord,
    join_trajectories,
    time_tool_path,
)
from planner.tool_paths.tool_path import ToolPath
from planner.tool_paths.tube import NO_DEVIATION, Deviation, Tube
from planner.trajectory.limits import MotionLimits
from planner.trajectory.trajectory import Trajectory

_ENDS = 8  # first rungs with the least cost-to-go, goals of the free motion
_FAST_STEP = 0.004  # m between stations with a tool speed, which changes little on that length


def follow(
    path: StrPath | Mapping[str, Any] | ToolPath,
    *,
    robot: RobotLike = ROBOT,
    scene: SceneLike = SCENE,
    request: FollowRequest | None = None,
    timing: TimingRequest | None = TimingRequest(),  # noqa: B008 (frozen)
    objective: Objective | None = None,
    progress: Progress = QUIET,
    **options: Any,
) -> Plan:
    """Plan a joint path that follows a tool path within its tube, proven between samples too.

        planner.follow("seam.yaml", robot="panda", scene="table", beta=0.2)

    ``path`` is a file, its keys, or the result of :func:`planner.read_tool_path`; ``options`` are fields of
    :class:`FollowRequest`, all else is as in :func:`planner.plan`. Joints never jump: each motion between two solutions
    is proven to stay in the tube. With a ``start`` a free motion leads to the path. If only a first section can be
    followed, the plan holds it, with ``Outcome.PARTLY_FOLLOWED`` and a reason. Raises :class:`PlannerError`.
    """
    request = build_request(request or FollowRequest(), objective, options, robot, scene)
    if timing is not None and timing.extra_cost != TimingRequest().extra_cost and request.what.start is None:
        raise OptionError("--extra-cost needs --start: give a start, or leave --extra-cost out.")
    if timing is None and request.what.tool_speed is not None:
        raise OptionError("--tool-speed needs a motion in time: leave --tool-speed or --no-timing out.")
    return Follower.from_tool_path(path, request, progress).plan(request, progress, timing)


@dataclass(frozen=True, eq=False)
class Follower:
    """A tool path with its ladder in one world.

    The ladder does not depend on beta or start: ``follower.plan(request.with_options(beta=0.9))`` uses it again.
    """

    checker: CollisionChecker
    path: ToolPath
    reached: LadderProgress
    request: FollowRequest  # of the ladder
    timings: dict[str, float]

    @staticmethod
    def from_tool_path(
        tool_path: StrPath | Mapping[str, Any] | ToolPath, request: FollowRequest, progress: Progress = QUIET
    ) -> Follower:
        """Build the ladder of a tool path: all that does not depend on beta or start."""
        clock = Stopwatch()
        progress("setup", 0, 1)
        with clock("setup"):
            path = tool_path if isinstance(tool_path, ToolPath) else read_tool_path(tool_path)
            start = None if request.what.start is None else lambda checker: _resolve_starts(request, checker)[0]
            checker = make_checker_for(request.what, start=start)
            if checker.world.scene.moving:
                raise SceneError(
                    f"scene '{checker.world.scene.name}' must have no moving obstacles for a tool path: remove them."
                )
        progress("setup", 1, 1)
        tube = Tube(path.subdivide())
        reached = _climb_ladder(tube, checker, request, progress, clock)
        if not reached.whole:
            inside = _climb_ladder(replace(tube, all_of_it=True), checker, request, progress, clock)
            reached = max(reached, inside, key=lambda each: each.share)
        return Follower(checker, path, reached, request, clock.seconds)

    def plan(self, request: FollowRequest, progress: Progress = QUIET, timing: TimingRequest | None = None) -> Plan:
        """Plan for another ``beta`` or ``start``; all options of the ladder are those of the first request."""
        clock, robot = Stopwatch(self.timings), self.checker.robot
        limits = None if timing is None else MotionLimits.from_robot(robot, timing)
        shared: dict[str, Any] = {"checker": self.checker, "timings": clock.seconds}
        if request.what.start is not None:
            states = states_of(robot, self.checker.world.scene)
            shared["end_notes"] = tuple(other_turns(request.what.start, self.checker, states))
        roadmap, along = self.reached.roadmap, self.reached.along
        if not len(roadmap.goals):
            return self._complete(Plan(request, Outcome.NO_PATH, roadmap=roadmap, **shared), along)
        draft = Plan(request, Outcome.INTERRUPTED, roadmap=roadmap, **shared)
        if progress.stopped:
            return draft
        if request.what.start is not None:
            with clock("roadmap"):
                grown = load_or_build_roadmap(request.quality, self._make_query(request, draft), progress)
                free = improve_plan(replace(draft, roadmap=grown), progress)
                if progress.stopped:
                    return draft
                if not free.roadmap.is_connected:
                    failed = replace(free, outcome=Outcome.NO_PATH)
                    return self._complete(replace(failed, reason=why_no_path(failed, progress)), along)
                roadmap, along = _join(free, roadmap, along)
        with clock("costs"):
            network = _drop_backward_arcs(build_network(roadmap, request.quality.objective), along)
        solved = solve_and_heal(replace(draft, roadmap=roadmap), network, clock)
        if timing is None or limits is None or not len(solved.path):
            return self._complete(solved, along)
        with clock("timing"):
            motion, speed, off = self._time(solved, along, request, timing, limits)
        return self._complete(replace(solved, trajectory=motion), along, speed, off)

    def _time(
        self, plan: Plan, along: Floats, request: FollowRequest, timing: TimingRequest, limits: MotionLimits
    ) -> tuple[Trajectory, ToolSpeedRecord | None, Deviation]:
        """Return the motion, at rest between free motion and tool path; the tool's speed, and its deviation."""
        places = along[plan.path_nodes]
        first, floor = int(np.argmax(places >= 0.0)), request.quality.min_manipulability
        on_path = plan.path[first:], places[first:], self.reached.ladder.tube, self.checker, limits
        motion, speed = time_tool_path(*on_path, request.what.tool_speed, floor, timing.time_law)
        off = self.reached.ladder.tube.deviation_of(motion, plan.robot, places[first:])
        if first:
            free = time_plan(replace(plan, path=plan.path[: first + 1]), timing, limits)
            motion = join_trajectories(free, motion, self.checker, limits, floor)
        return recheck(motion, self.checker), speed, off

    def _make_query(self, request: FollowRequest, draft: Plan) -> Query:
        """Return the query from the start to the first rungs with the least cost-to-go."""
        checker, ladder = self.checker, draft.roadmap
        start = _resolve_starts(request, checker)
        network = _drop_backward_arcs(build_network(ladder, request.quality.objective), self.reached.along)
        cost = gabf.oracle(network)[ladder.starts]
        best = ladder.starts[np.argsort(cost, kind="stable")[: min(_ENDS, int(np.isfinite(cost).sum()))]]
        goals = ladder.nodes[best]
        return Query(checker.robot, draft.scene, checker, start, goals, ("tool path",) * len(goals))

    def _lower_floor(self) -> float | None:
        """Return the highest floor with which the path is followed farther; None if it is no limit."""
        if self.request.quality.min_manipulability <= 0:
            return None
        lower = follow_ladder(self.reached.ladder, self.checker, 0.0, self.request.quality.seed)
        if lower.along.max() <= self.reached.along.max() + 1e-9:
            return None
        network = _drop_backward_arcs(build_network(lower.roadmap, self.request.quality.objective), lower.along)
        return highest_floor(self.checker.robot, lower.roadmap, network)

    def _complete(
        self,
        solved: Plan,
        along: Floats,
        speed: ToolSpeedRecord | None = None,
        of_motion: Deviation = NO_DEVIATION,
    ) -> Plan:
        """Return the plan with the record of its tool path, and why it is not followed to its end."""
        outcome, reason, off = solved.outcome, solved.reason, NO_DEVIATION
        reached, share, ends = self.reached, 0.0, self.reached.ends[:0]
        if len(solved.path):
            share, ends, places = reached.share, reached.ends, along[solved.path_nodes]
            rows = places >= 0.0
            off = reached.ladder.tube.largest_deviation(solved.robot, solved.path[rows], places[rows])
        if not reached.whole and reason is None:
            outcome = Outcome.PARTLY_FOLLOWED
            reason = explain_stop(self.checker, reached.ladder, share, ends, self._lower_floor())
        record = ToolPathRecord(
            followed=share,
            points=int(self.path.given.max()),
            largest_deviation=off.max_with(of_motion),
            tube=self.path.tube,
            proven=bool(len(solved.path)) and (solved.trajectory is None or solved.trajectory.proven),
            first_unreachable=reason.point if isinstance(reason, CannotFollow) else None,
            speed=speed,
        )
        rungs = reached.roadmap.nodes[: len(reached.roadmap.nodes) if len(reached.ends) else 0]
        return replace(
            solved,
            outcome=outcome,
            reason=reason,
            goal="tool-path" if len(solved.path) else None,
            tool_path=FollowedPath(record, self.path.positions, rungs),
        )


def _climb_ladder(
    tube: Tube, checker: CollisionChecker, request: FollowRequest, progress: Progress, clock: Stopwatch
) -> LadderProgress:
    """Build a ladder in a tube, and find how far it leads."""
    with clock("ladder"):
        progress("ladder", 0, 0)
        step = None if request.what.tool_speed is None else _FAST_STEP
        prover = EdgeProver(checker)
        how = request.quality.seed, request.what.ladder_density, lambda q: prover.free(q, np.zeros_like(q))
        ladder = build_ladder(checker.robot, tube, step, *how)
        progress("ladder", len(ladder.q), len(ladder.q))
    with clock("proofs"):
        return follow_ladder(ladder, checker, request.quality.min_manipulability, request.quality.seed, progress)


def _resolve_starts(request: FollowRequest, checker: CollisionChecker) -> Floats:
    """Return the start configurations (k, dof) of the free motion."""
    states = states_of(checker.robot, checker.world.scene)
    assert request.what.start is not None  # callers check this
    return resolve(request.what.start, checker, states, "start", tolerance=request.what.ik_tolerance)


def _drop_backward_arcs(network: gabf.Network, along: Floats) -> gabf.Network:
    """Return the network without arcs that lead back along the path; ``along`` is -1 off the path."""
    tails, heads = along[network.tails], along[network.indices]
    return network.without_arcs(np.flatnonzero((tails > heads) & (tails > 1e-9)))


def _join(free: Plan, ladder: Roadmap, along: Floats) -> tuple[Roadmap, Floats]:
    """Return the free roadmap with the ladder behind its goals, without the other first rungs."""
    roadmap = try_min_clearance(free.roadmap, free.clearance_kept)
    number = np.where(along > 1e-9, NEW, LEFT_OUT)
    for goal in roadmap.goals:
        away = free.robot.difference(ladder.nodes[ladder.starts], roadmap.nodes[goal])
        same = np.abs(away).max(axis=1) < 1e-9
        number[ladder.starts[same]] = goal
    joined, number = attach_ladder(free.robot, roadmap, ladder, number)
    places = np.full(len(joined.nodes), -1.0)
    places[number[number >= 0]] = along[number >= 0]
    return replace(joined, goals=number[ladder.goals]), places
