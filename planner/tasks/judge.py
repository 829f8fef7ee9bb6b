"""A planned task checked whole, from its record alone: where everything is follows from the events."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from planner.base.arrays import Floats
from planner.base.errors import FileError, choices
from planner.base.polynomials import evaluate
from planner.base.yamlfile import Number, read_text, validate
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.looks import looks_along, straight
from planner.kinematics.forward import tool_joint
from planner.planning.result import JSON_NAME
from planner.problem.outcome import Outcome
from planner.query.in_hand import let_go, placement_of, taken
from planner.robot.poses import pose
from planner.robot.robot import Robot, with_carried, with_tool, without_carried
from planner.robot.shapes import Carried, Obstacle, extremes
from planner.tasks.candidates import RELEASE
from planner.tasks.modes import Pairs
from planner.tasks.sampling import gripper_of, place_at, standing
from planner.tasks.segments import Event, Segment, SegmentTimes
from planner.tasks.task import Gripper, TaskError
from planner.trajectory.check import TrajectoryReport, check
from planner.trajectory.path_check import PathReport
from planner.trajectory.path_file import parse, require_of_an_arm
from planner.trajectory.trajectory import Trajectory

_SAME = 1e-6  # rad (m): joint values in two files
_MOVED = 1e-3  # m: an object so much elsewhere is held otherwise
_NEAR = RELEASE + 1e-4  # m, and the margin: so near its rest an object may touch what it stands on
_ORDERS = [], ["gripper", "attach"], ["detach", "gripper"]  # of events at the end of a segment


class TaskRecord(pydantic.BaseModel):
    """What a check needs of a task's ``plan.json``."""

    outcome: str
    joints: list[str]
    path: list[list[Number]]
    segments: list[Segment]
    events: list[Event]


@dataclass(frozen=True, eq=False)
class SegmentReport:
    """The ``report`` on a segment's motion, the pairs that may touch on it, and all its faults, as sentences."""

    report: PathReport | TrajectoryReport
    may_touch: Pairs
    findings: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Whether it has no fault."""
        return not self.findings


def task_record(path: Path) -> TaskRecord | None:
    """The record of a task by its folder, its ``plan.json``, or what stands beside that; None for anything else."""
    place = (path if os.path.isdir(path) else path.parent) / JSON_NAME
    if not (os.path.isdir(path) or path.name in (JSON_NAME, "trajectory.json")) or not os.path.isfile(place):
        return None
    where = f"plan {place}"
    data = parse(read_text(place, "plan"), where)
    return validate(TaskRecord, data, where) if isinstance(data, dict) and "segments" in data else None


def judged(
    record: TaskRecord, checker: CollisionChecker, whole: Trajectory | None, step: float
) -> Iterator[tuple[Segment, SegmentReport]]:
    """Each segment with what is found on it, with what is held, and what stands where, by then.

    ``checker`` is of the scene before the task, ``whole`` the motion of all segments where there is one; looked at
    every ``step`` metres. Pairs that the record lets touch may if they are a hand and what it goes to or leaves, or an
    object near its rest and what it stands on, as measured. Raises :class:`FileError` for what is no such task.
    """
    _require_task(record, checker, whole)
    stage, before, begun, walked = Stage(checker, record.events), None, None, list[list[float]]()
    for number, segment in enumerate(record.segments):
        path = segment.path
        _require_fitting(number, segment, path, before, stage)
        made = None if whole is None or segment.trajectory is None else _part(whole, segment.trajectory, path)
        events = [event for event in record.events if event.segment == number]
        following = next((event for event in events if event.kind != "gripper"), None)
        hand, rests, found = stage.excuse_pairs(segment, path, begun, following)
        may_touch = hand.union(*rests.values())
        report = check(path, stage.checker(may_touch), step)
        if report.ok and made is not None:
            report = check(made, stage.checker(may_touch), step)
        if not report.ok:
            found.append("beyond limits" if report.contact is None else str(report.contact.contact))
        elif rests:
            found += _find_contacts_off_rest(path, made, stage, hand, rests, step)
        walked += path[len(walked) > 0 :].tolist()
        if segment is record.segments[-1] and record.path != walked:
            found.append("The path of the task must be that of its segments: plan again.")
        yield segment, SegmentReport(report, may_touch, (*found, *_check_commands(events, stage.robot)))
        before, begun = path[-1], following
        for event in events:
            stage.after(event, before)
    if whole is not None:
        _require_all_of_it(record, whole)


def _require_task(record: TaskRecord, checker: CollisionChecker, whole: Trajectory | None) -> None:
    """Raise :class:`FileError` for what is no solved task of this robot with one path and the events of its motion."""
    if whole is not None and [dict(event) for event in whole.events] != [event.to_dict() for event in record.events]:
        raise FileError("the task has other events than its trajectory: one of the files is damaged, plan again.")
    if record.outcome != Outcome.SOLVED.key or not record.segments:
        raise FileError(f"a task must be solved, got '{record.outcome}', {len(record.segments)} segments: plan again.")
    if any(event.segment >= len(record.segments) for event in record.events):
        raise FileError("an event of the task comes after a segment that is not there: it is damaged, plan again.")
    joints = checker.robot.joints
    if tuple(record.joints) != joints or (whole is not None and whole.joints != joints):
        raise FileError(f"joints of the task and its trajectory must be {choices(joints)} in this order: plan again.")


def _check_commands(events: Sequence[Event], robot: Robot) -> Iterator[str]:
    """Yield faults of the gripper's commands at the end of a segment; a robot without fingers needs none."""
    kinds = [event.kind for event in events if event.kind != "gripper" or event.joints]
    if kinds not in _ORDERS and ("gripper" in kinds or gripper_of(robot, Gripper()).closed):
        yield f"Events at its end must be gripper, attach or detach, gripper; got {', '.join(kinds)}: plan again."
    for event in events:
        try:
            gripper_of(robot, Gripper(open=event.joints or {}))
        except TaskError as error:
            yield str(error)


def _find_contacts_off_rest(
    path: Floats, made: Trajectory | None, stage: Stage, hand: Pairs, rests: dict[int, Pairs], step: float
) -> Iterator[str]:
    """Yield the first contact on path and motion off the rest of the held object that is excused at its rest only."""
    strict, held = second_checker(stage.checker(hand)), stage.held
    assert held is not None
    for pieces in (straight(path[:-1], np.diff(path, axis=0)), *(() if made is None else (made.coefficients,))):
        looks = looks_along(strict, pieces, step)
        q = evaluate(pieces[looks.piece], looks.s)
        at = np.array([stage.pose(held.name, row) for row in q])
        off = np.min([_measure_shift(held, at, stage.pose(held.name, path[row])) for row in rests], axis=0)
        far = off > _NEAR + strict.world.margin
        if far.any() and (seen := strict.first_contact(q[far])):
            touch = f"{seen[1]} {seen[1].how(strict.world.margin)} {1e3 * off[far][seen[0]]:.3g} mm"
            yield f"{touch} off the rest of '{held.name}', they may within {1e3 * RELEASE:g} mm: plan again."


def _measure_shift(item: Carried | Obstacle, a: Floats, b: Floats) -> Floats:
    """How far (n,) m a point of an item at most is in placements ``a`` (n, 4, 4) from where it is in ``b`` (4, 4)."""
    points = np.where(np.indices((2, 2, 2)).reshape(3, 8).T, *reversed(extremes(item.shape)))
    return np.linalg.norm((a - b)[..., :3, :3] @ points.T + (a - b)[..., :3, 3:], axis=-2).max(axis=-1)


def _require_all_of_it(record: TaskRecord, whole: Trajectory) -> None:
    """Raise :class:`FileError` where a motion goes on outside the segments, or an event does not come between them."""
    damaged = "one of the files is damaged, plan again"
    timed = [segment.trajectory for segment in record.segments if segment.trajectory is not None]
    if len(timed) < len(record.segments):
        raise FileError(f"the task has a trajectory, and segments without times: {damaged}.")
    begins = [*(round(times.begin * 1e9) for times in timed), int(whole.nanoseconds[-1])]
    ends = [int(whole.nanoseconds[0]), *(round((times.begin + times.duration) * 1e9) for times in timed)]
    for number, (end, begin) in enumerate(zip(ends, begins, strict=True)):
        rows, h = (whole.nanoseconds >= end) & (whole.nanoseconds <= begin), 1e-9 * (begin - end)
        where = f"after segment {number}" if number else "before its first segment"
        if not rows.any():
            raise FileError(f"the trajectory of the task has other times {where} than its segments: {damaged}.")
        rates = sum(np.abs(rate[rows]).max() * h**k for k, rate in enumerate(whole.columns) if k)
        if max(rates, np.ptp(whole.columns[0][rows], axis=0).max()) > _SAME:
            raise FileError(f"the trajectory of the task moves on {where}: {damaged}.")
        moments = [event.t for event in record.events if event.segment == number - 1]
        if any(t is None or not end - 1 <= 1e9 * t <= begin + 1 for t in moments):
            raise FileError(f"an event of the task does not come {where}, where it belongs: {damaged}.")


def _require_fitting(number: int, segment: Segment, path: Floats, before: Floats | None, stage: Stage) -> None:
    """Raise :class:`FileError` for a segment that does not follow from the one before it and from the events."""
    head, robot = f"segment {number + 1}", stage.robot
    held = None if stage.held is None else stage.held.name
    if path.shape[1] != robot.dof:
        raise FileError(f"{head} has {path.shape[1]} columns, {robot.name} has {robot.dof} joints.")
    require_of_an_arm(path, robot, head)
    if len(path) < 2:
        raise FileError(f"{head} has a path of one waypoint: give two at least.")
    if before is not None and np.abs(path[0] - before).max() > _SAME:
        raise FileError(f"{head} begins elsewhere than the one before it ends: the file is damaged, plan again.")
    if segment.carried != held:
        said, truth = (f"'{name}'" if name else "nothing" for name in (segment.carried, held))
        raise FileError(f"{head} says that {said} is held, by the events it is {truth}: plan again.")


class Stage:
    """What stands where and what is held, event after event: the scene of a ``checker`` before the task at first.

    What the scene lets the arm carry, and the first event lets go of, is held at the beginning.
    """

    def __init__(self, checker: CollisionChecker, events: Sequence[Event]) -> None:
        self._known, self.scene = checker, checker.world.scene
        first = next((event for event in events if event.kind != "gripper"), None)
        self._name = first.object if first is not None and first.kind == "detach" else None
        self.robot = checker.robot if self.held is None else without_carried(checker.robot, self.held.name)

    @property
    def held(self) -> Carried | None:
        """What the task holds; what the scene lets the arm carry besides is part of the robot."""
        return next((item for item in self.scene.carried if item.name == self._name), None)

    def checker(self, allowed: Pairs) -> CollisionChecker:
        """A checker of what there is now, where these pairs of names may touch besides."""
        robot = self.robot if self.held is None else with_carried(self.robot, [self.held])
        there = replace(self.scene, allowed=self.scene.allowed | allowed)
        return type(self._known)(self._known.world.among(there, robot), self._known)

    def excuse_pairs(
        self, segment: Segment, path: Floats, begun: Event | None, following: Event | None
    ) -> tuple[Pairs, dict[int, Pairs], list[str]]:
        """Pairs of hand and object that may touch, pairs at a rest by its row of the path, and faults of a release."""
        declared = frozenset(frozenset(pair) for pair in (*segment.may_touch, *segment.at_rest))
        robot, held, hand, rests, found = self.robot, self.held, Pairs(), dict[int, Pairs](), list[str]()
        links = [body.link for body in robot.bodies if tool_joint(robot)[0] in robot.model.supports[body.joint]]
        among = type(self._known)(self._known.world.among(self.scene, robot), self._known)
        for row, event in ((0, begun), (-1, following)):
            if event is not None and held is not None and held.name == event.object:
                item = Obstacle(held.name, held.shape, self.pose(held.name, path[row]))
                try:
                    place = (place_at if row else standing)(item, item.placement, among)
                    rests[row] = declared & {frozenset((held.name, on)) for on in place.supports}
                except TaskError as error:
                    found.append(str(error))
            elif event is not None:
                hand |= declared & {frozenset((event.object, link)) for link in links}
        return hand, rests, found

    def pose(self, name: str, q: Floats) -> Floats:
        """Where an object is (4, 4) in a configuration (dof,)."""
        if self.held is not None and self.held.name == name:
            return placement_of(self.held, self.robot, q)
        return next(item for item in self.scene.obstacles if item.name == name).placement

    def after(self, event: Event, q: Floats) -> None:
        """Take or let go, in a configuration (dof,); :class:`FileError` for what is not there."""
        name, held = event.object, self.held
        if event.kind == "attach":
            if held is not None:
                raise FileError(f"the task takes '{name}' while it holds '{held.name}': mend the file.")
            item = next((item for item in self.scene.obstacles if item.name == name), None)
            if item is None:
                raise FileError(f"the task takes '{name}', which is not in scene '{self.scene.name}': give its scene.")
            if tool_joint(with_tool(self.robot, event.link))[0] != tool_joint(self.robot)[0]:
                raise FileError(f"the task takes '{name}' with '{event.link}', which does not move with the tool.")
            _require_there(event, item, item.placement, f"in scene '{self.scene.name}'")
            self.scene, self._name = taken(self.scene, item, self.robot, event.link, q), name
        elif event.kind == "detach":
            if held is None or held.name != name:
                raise FileError(f"the task lets go of '{name}', which it does not hold: mend the file.")
            _require_there(event, held, self.pose(name, q), "in the hand")
            self.scene, self._name = let_go(self.scene, held, self.robot, q), None


def _require_there(event: Event, item: Carried | Obstacle, placement: Floats, where: str) -> None:
    """Raise :class:`FileError` where an object is elsewhere than the plan had it."""
    if event.position is None or event.quaternion is None:
        return
    away = float(_measure_shift(item, placement, pose(event.position, quaternion=event.quaternion)))
    if away > _MOVED:
        off = f"is {where} {1e3 * away:.3g} mm"
        raise FileError(f"at its {event.kind} '{event.object}' {off} from where the plan has it: plan again.")


def _part(whole: Trajectory, times: SegmentTimes, path: Floats) -> Trajectory:
    """The part of a motion that a segment is; :class:`FileError` where it does not join the ends of its ``path``."""
    begin, end = round(times.begin * 1e9), round((times.begin + times.duration) * 1e9)
    rows = np.flatnonzero((whole.nanoseconds >= begin) & (whole.nanoseconds <= end))
    if len(rows) < 2:
        raise FileError("the segments of the task have other times than its trajectory: plan again.")
    columns = tuple(column[rows] for column in whole.columns)
    if np.abs(columns[0][[0, -1]] - path[[0, -1]]).max() > _SAME:
        raise FileError("the segments of the task have other paths than its trajectory: plan again.")
    return Trajectory(whole.joints, whole.nanoseconds[rows], columns, whole.law, whole.limits)


def summary(reports: Sequence[tuple[Segment, SegmentReport]]) -> dict[str, Any]:
    """Whether all segments are as they should be, and each of them, as plain data."""
    found = [
        {name: getattr(segment, name) for name in ("step", "doing", "part", "carried")}
        | {
            "ok": each.ok,
            "contact": None if each.report.contact is None else str(each.report.contact.contact),
            "may_touch": sorted(map(sorted, each.may_touch)),
            "findings": list(each.findings),
        }
        for segment, each in reports
    ]
    return {"ok": all(each["ok"] for each in found), "segments": found}
