"""Straight tool lines from a plan's start (retreat) and to its goal (approach), each a proven ladder."""

from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.collision.checker import CollisionChecker
from planner.constraints.tool_bound import Frame
from planner.planning.result import Plan
from planner.planning.solve import time_plan
from planner.problem.outcome import CannotFollow
from planner.problem.request import PlanRequest, TimingRequest
from planner.query.query import Query
from planner.roadmap.roadmap import Roadmap, try_min_clearance
from planner.robot.robot import Robot
from planner.tool_paths.ladder import continue_ladder
from planner.tool_paths.ladder_roadmap import NEW, LadderProgress, attach_ladder, explain_stop, follow_ladder
from planner.tool_paths.tool_motion import LegRecord, join_trajectories, leg_line, time_tool_path
from planner.tool_paths.tool_path import ToolPath
from planner.tool_paths.tube import Tube
from planner.trajectory.limits import MotionLimits


@dataclass(frozen=True, eq=False)
class Legs:
    """The legs of a plan: ``retreats`` from its starts and ``approaches`` to its goals, or empty.

    A leg is a chain of proven motions between an end of the plan and an end of the free motion.
    """

    retreats: tuple[LadderProgress, ...] = ()
    approaches: tuple[LadderProgress, ...] = ()

    def query_between(self, query: Query) -> Query:
        """Return the query of the free motion, between the inner ends of the legs."""
        if self.retreats:
            query = replace(query, starts=np.array([leg.ends[0] for leg in self.retreats]))
        if self.approaches:
            goals = np.array([leg.ends[0] for leg in self.approaches])
            query = replace(query, goals=goals, goal_names=("approach",) * len(goals))
        return query

    def attach(self, free: Plan) -> Plan:
        """Return the plan with the legs in its roadmap; starts and goals are those of the request."""
        if not (self.retreats or self.approaches):
            return free
        roadmap = try_min_clearance(free.roadmap, free.clearance_kept)
        roadmap, starts = _join(free.robot, roadmap, self.retreats, roadmap.starts)
        roadmap, goals = _join(free.robot, roadmap, self.approaches, roadmap.goals)
        return replace(free, roadmap=replace(roadmap, starts=starts, goals=goals), clearance_kept=0.0)

    def legs_at_ends(self, robot: Robot, path: Floats) -> tuple[LadderProgress | None, LadderProgress | None]:
        """Return the legs at the start and the end of a path (k, dof), up to whole turns."""
        begin, end = (
            next((leg for leg in legs if np.abs(robot.difference(_end(leg), q)).max() < 1e-9), None)
            for legs, q in ((self.retreats, path[0]), (self.approaches, path[-1]))
        )
        return begin, end

    def time(self, plan: Plan, timing: TimingRequest, limits: MotionLimits | None) -> Plan:
        """Return the plan with its motion: at rest between a leg and the free motion, with rounded corners."""
        begin, end = self.legs_at_ends(plan.robot, plan.path)
        if begin is None and end is None:
            return replace(plan, trajectory=time_plan(plan, timing, limits))
        limits = limits or MotionLimits.from_robot(plan.robot)
        first = len(begin.along) - 1 if begin else 0
        last = len(plan.path) - (len(end.along) - 1 if end else 0)
        motion = time_plan(replace(plan, path=plan.path[first:last]), timing, limits)
        floor, records = plan.request.quality.min_manipulability, list(plan.legs)
        for leg, part, before in ((begin, plan.path[: first + 1], True), (end, plan.path[last - 1 :], False)):
            if leg is not None:
                tube, places = leg.ladder.tube, np.sort(leg.along)
                if not before:
                    tube, places = Tube(tube.path.backwards), places[-1] - places[::-1]
                straight, _ = time_tool_path(part, places, tube, plan.checker, limits, None, floor)
                parts = (straight, motion) if before else (motion, straight)
                motion = join_trajectories(*parts, plan.checker, limits, floor)
                k = 0 if before else -1
                off = records[k].largest_deviation.max_with(tube.deviation_of(straight, plan.robot, places))
                records[k] = replace(records[k], largest_deviation=off)
        return replace(plan, trajectory=motion, legs=tuple(records))

    def make_records(self, robot: Robot, path: Floats) -> tuple[LegRecord, ...]:
        """Return the records of the legs of a path (k, dof)."""
        records, (begin, end) = [], self.legs_at_ends(robot, path)
        for name, leg in (("retreat", begin), ("approach", end)):
            if leg is not None:
                order, tube = np.argsort(leg.along), leg.ladder.tube
                off = tube.largest_deviation(robot, leg.roadmap.nodes[order], leg.along[order])
                length = float(leg.along.max())
                records.append(LegRecord(leg=name, length=length, largest_deviation=off, tube=tube.path.tube))
        return tuple(records)


def _end(leg: LadderProgress) -> Floats:
    """Return the outer end (dof,) of a leg."""
    return leg.roadmap.nodes[leg.roadmap.starts[0]]


def _join(robot: Robot, roadmap: Roadmap, legs: tuple[LadderProgress, ...], doors: Ints) -> tuple[Roadmap, Ints]:
    """Return the roadmap with legs joined at its nodes ``doors``, and the nodes of their outer ends."""
    ends = []
    for leg in legs:
        number = np.full(len(leg.along), NEW)
        away = np.abs(robot.difference(roadmap.nodes[doors], leg.ends[0])).max(axis=1)
        number[leg.roadmap.goals[0]] = doors[away.argmin()]
        roadmap, number = attach_ladder(robot, roadmap, leg.roadmap, number)
        ends.append(number[leg.roadmap.starts[0]])
    return roadmap, np.array(ends) if legs else doors


def find_legs(query: Query, request: PlanRequest) -> Legs | CannotFollow:
    """Return the legs of ``request`` for all ends that have one, or why no end has one."""
    legs: dict[str, tuple[LadderProgress, ...]] = {}
    for name, ends, length in (
        ("retreat", query.starts, request.what.retreat),
        ("approach", query.goals, request.what.approach),
    ):
        tried = [_build_leg(query.checker, q, length, request.quality.seed) for q in ends] if length > 0 else []
        legs[name] = tuple(leg for leg in tried if leg.whole)
        if tried and not legs[name]:
            k = int(np.argmax([leg.share for leg in tried]))
            reached = tried[k].ends if len(tried[k].ends) else ends[[k]]
            return replace(explain_stop(query.checker, tried[k].ladder, tried[k].share, reached), leg=name, cone=None)
    return Legs(legs["retreat"], legs["approach"])


def _build_leg(checker: CollisionChecker, q: Floats, length: float, seed: int) -> LadderProgress:
    """Build the leg back along the tool's z axis from ``q`` (dof,), as far as it is feasible."""
    rotation, _ = Frame.tool(checker.robot).poses(checker.robot, q[None])
    positions = leg_line(checker.robot, q, length)
    path = ToolPath("leg", positions, np.repeat(rotation, 2, axis=0), np.zeros(2, bool), np.zeros(2), np.arange(1, 3))
    return follow_ladder(continue_ladder(checker.robot, Tube(path), q), checker, 0.0, seed)
