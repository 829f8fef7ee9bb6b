"""Straight lines of the tool out of a plan's start and into its goal, each a proven ladder of its own."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats
from planner.collision.checker import CollisionChecker
from planner.kinematics.tool_bound import Frame
from planner.planning.motion import timed
from planner.planning.result import Plan
from planner.problem.outcome import CannotFollow
from planner.problem.request import PlanRequest, TimingRequest
from planner.query.query import Query
from planner.roadmap.roadmap import Roadmap, roomy_where_joined
from planner.robot.robot import Robot
from planner.tool_paths.followed import LegRecord, leg_line
from planner.tool_paths.ladder import ladder_from
from planner.tool_paths.ladder_roadmap import NEW, Reached, attached, reached_on
from planner.tool_paths.timing import joined_motion, time_tool_path
from planner.tool_paths.tool_path import ToolPath
from planner.tool_paths.tube import Tube
from planner.tool_paths.why_not import why_not
from planner.trajectory.limits import MotionLimits


@dataclass(frozen=True, eq=False)
class Leg:
    """A line of the tool back from ``end`` (dof,), an end of a plan, to where the free motion is joined to it.

    ``found``: a chain of proven motions, whose start is that end and whose goal is the other one.
    """

    end: Floats
    found: Reached

    @property
    def roadmap(self) -> Roadmap:
        assert self.found.roadmap is not None  # the leg is whole
        return self.found.roadmap

    @property
    def free(self) -> Floats:
        return self.found.ends[0]

    @property
    def places(self) -> Floats:
        """(n,) m from the end."""
        return np.sort(self.found.along)

    def record(self, name: str, robot: Robot) -> LegRecord:
        """What ``plan.json`` says of it under a ``name``."""
        tube, order = self.found.ladder.tube, np.argsort(self.found.along)
        _, off = tube.largest_deviation(robot, self.roadmap.nodes[order], self.places)
        return LegRecord(
            leg=name,
            length=float(self.places[-1]),
            largest_deviation=off,
            tube=tube.path.tube,
        )


@dataclass(frozen=True, eq=False)
class Legs:
    """The legs of a plan: ``retreats`` from its starts, ``approaches`` to its goals; empty where none is asked for."""

    retreats: tuple[Leg, ...] = ()
    approaches: tuple[Leg, ...] = ()

    def between(self, query: Query) -> Query:
        """What the free motion has to join."""
        if self.retreats:
            query = replace(query, starts=np.array([leg.free for leg in self.retreats]))
        if self.approaches:
            goals = np.array([leg.free for leg in self.approaches])
            query = replace(query, goals=goals, goal_names=("approach",) * len(goals))
        return query

    def attached(self, free: Plan) -> Plan:
        """The plan on its roadmap with the legs, in which starts and goals are what was asked for."""
        if not (self.retreats or self.approaches):
            return free
        roadmap = roomy_where_joined(free.roadmap, free.clearance_kept)
        ends = {"starts": (self.retreats, roadmap.starts), "goals": (self.approaches, roadmap.goals)}
        for name, (legs, doors) in ends.items():
            numbers = []
            for leg in legs:
                number = np.full(len(leg.places), NEW)
                away = np.abs(free.robot.difference(roadmap.nodes[doors], leg.free)).max(axis=1)
                number[leg.roadmap.goals[0]] = doors[away.argmin()]
                roadmap, number = attached(free.robot, roadmap, leg.roadmap, number)
                numbers.append(number[leg.roadmap.starts[0]])
            if numbers:
                roadmap = replace(roadmap, **{name: np.array(numbers)})
        return replace(free, roadmap=roadmap, clearance_kept=0.0)

    def of(self, robot: Robot, path: Floats) -> tuple[Leg | None, Leg | None]:
        """The legs with which a path (k, dof) begins and ends, whole turns aside."""
        begin, end = (
            next((leg for leg in legs if np.abs(robot.difference(leg.end, q)).max() < 1e-9), None)
            for legs, q in ((self.retreats, path[0]), (self.approaches, path[-1]))
        )
        return begin, end

    def timed(self, found: Plan, timing: TimingRequest, limits: MotionLimits | None) -> Plan:
        """The plan with the motion along its path, resting between a leg and what is free; corners are rounded."""
        begin, end = self.of(found.robot, found.path)
        if begin is None and end is None:
            return replace(found, trajectory=timed(found, timing, limits))
        limits = limits or MotionLimits.of(found.robot)
        first = len(begin.places) - 1 if begin else 0
        last = len(found.path) - (len(end.places) - 1 if end else 0)
        made = timed(replace(found, path=found.path[first:last]), timing, limits)
        floor, records = found.request.quality.min_manipulability, list(found.legs)
        for leg, part, before in ((begin, found.path[: first + 1], True), (end, found.path[last - 1 :], False)):
            if leg is not None:
                tube = leg.found.ladder.tube
                tube = tube if before else Tube(tube.path.backwards)
                places = leg.places if before else leg.places[-1] - leg.places[::-1]
                straight, _ = time_tool_path(part, places, tube, found.checker, limits, None, floor)
                parts = (straight, made) if before else (made, straight)
                made = joined_motion(*parts, found.checker, limits, floor)
                of_path = records[0 if before else -1]
                off = of_path.largest_deviation.or_more(tube.deviation_of(straight, found.robot, places))
                records[0 if before else -1] = replace(of_path, largest_deviation=off)
        return replace(found, trajectory=made, legs=tuple(records))

    def records(self, robot: Robot, path: Floats) -> tuple[LegRecord, ...]:
        """What ``plan.json`` says of the legs of a path."""
        begin, end = self.of(robot, path)
        return tuple(leg.record(name, robot) for name, leg in (("retreat", begin), ("approach", end)) if leg)


def legs_of(query: Query, request: PlanRequest) -> Legs | CannotFollow:
    """The legs that ``request`` asks for, of those ends that have one; why none has, where that is so."""
    found: dict[str, tuple[Leg, ...]] = {}
    for name, ends, length in (
        ("retreat", query.starts, request.what.retreat),
        ("approach", query.goals, request.what.approach),
    ):
        tried = [_leg(query.checker, q, length, request.quality.seed) for q in ends] if length > 0 else []
        found[name] = tuple(leg for leg in tried if leg.found.whole)
        if tried and not found[name]:
            farthest = max(tried, key=lambda leg: leg.found.share)
            reached = farthest.found.ends if farthest.found.roadmap else farthest.end[None]
            return replace(why_not(query.checker, farthest.found, reached), leg=name, cone=None)
    return Legs(found["retreat"], found["approach"])


def _leg(checker: CollisionChecker, q: Floats, length: float, seed: int) -> Leg:
    """The leg back along the tool's z axis from ``q`` (dof,), as far as it goes."""
    rotation, _ = Frame.tool(checker.robot).poses(checker.robot, q[None])
    positions = leg_line(checker.robot, q, length)
    path = ToolPath("leg", positions, np.repeat(rotation, 2, axis=0), np.zeros(2, bool), np.zeros(2), np.arange(1, 3))
    ladder = ladder_from(checker.robot, Tube(path), q)
    return Leg(q, reached_on(ladder, checker, 0.0, seed))
