"""A planned task checked whole, from its record alone: where everything is follows from the events."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from planner.base.arrays import Floats
from planner.base.errors import FileError, choices
from planner.base.files import is_file, is_folder
from planner.base.yamlfile import read_text, validate
from planner.collision.checker import CollisionChecker
from planner.models.poses import pose
from planner.models.robot import with_carried, without_carried
from planner.models.shapes import Carried
from planner.paths.check import PathReport
from planner.paths.file import matrix, parse, require_of_an_arm
from planner.planning.result import JSON_NAME
from planner.setup.in_hand import let_go, placement_of, taken
from planner.tasks.record import Event, SegmentRecord, SegmentTimes
from planner.trajectory.check import TrajectoryReport, check, looked_at
from planner.trajectory.trajectory import Trajectory

_SAME = 1e-6  # rad (m): joint values in two files
_MOVED, _TURNED = 1e-3, 1e-2  # m, rad: an object so much elsewhere is held otherwise
Report = PathReport | TrajectoryReport


class TaskRecord(pydantic.BaseModel):
    """What a check needs of a task's ``plan.json``."""

    segments: list[SegmentRecord]
    events: list[Event]


def task_record(path: Path) -> TaskRecord | None:
    """The record of a task by its folder, its ``plan.json``, or what stands beside that; None for anything else."""
    place = (path if is_folder(path) else path.parent) / JSON_NAME
    if not (is_folder(path) or path.name in (JSON_NAME, "trajectory.json")) or not is_file(place):
        return None
    where = f"plan {place}"
    data = parse(read_text(place, "plan"), where)
    return validate(TaskRecord, data, where) if isinstance(data, dict) and "segments" in data else None


def judged(
    record: TaskRecord, checker: CollisionChecker, whole: Trajectory | None, step: float
) -> Iterator[tuple[SegmentRecord, Report]]:
    """Each segment with what is found on it, with what is held, and what stands where, by then.

    ``checker`` is of the scene before the task, ``whole`` the motion of all segments where there is one; looked at
    every ``step`` metres. Where an object may touch what it stands on at its rest, all that is off the rest is looked
    at without that too. Raises :class:`FileError` for events that are not of this scene.
    """
    if whole is not None and [dict(event) for event in whole.events] != [event.to_dict() for event in record.events]:
        raise FileError("the task has other events than its trajectory: one of the files is damaged, plan again.")
    if not record.segments:
        raise FileError("the task has no segments, so there is nothing to judge: plan again.")
    if any(event.segment >= len(record.segments) for event in record.events):
        raise FileError("an event of the task comes after a segment that is not there: it is damaged, plan again.")
    if whole is not None and whole.joints != checker.robot.joints:
        raise FileError(f"the trajectory of the task is of the joints {choices(whole.joints)}: plan again.")
    stage, before = Stage(checker, record.events), None
    handled = {event.object for event in record.events}
    for number, segment in enumerate(record.segments):
        path = matrix(segment.path, f"segment {number + 1}")
        _require_fitting(number, segment, path, before, stage, handled)
        made = None if whole is None or segment.trajectory is None else _part(whole, segment.trajectory, path)
        yield segment, _report(segment, path, made, stage, step)
        before = path[-1]
        for event in (each for each in record.events if each.segment == number):
            stage.after(event, before)
    if whole is not None:
        _require_all_of_it(record, whole)


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


def _report(segment: SegmentRecord, path: Floats, made: Trajectory | None, stage: Stage, step: float) -> Report:
    """What is found on the path, and on the motion where there is one: the first that is not as it should be."""
    loose, strict = stage.checker([*segment.may_touch, *segment.at_rest]), stage.checker(segment.may_touch)
    report: Report = check(path, loose, step)
    off = path[1:] if segment.part == "retreat" else path[:-1]
    if report.ok and segment.at_rest and len(off) > 1:
        report = check(off, strict, step)
    if report.ok and made is not None:
        report = check(made, loose, step)
        if report.ok and segment.at_rest:
            report = replace(report, contact=looked_at(off_rest(made, path, segment.part), strict, step))
    return report


def _require_fitting(
    number: int, segment: SegmentRecord, path: Floats, before: Floats | None, stage: Stage, handled: set[str]
) -> None:
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
        raise FileError(
            f"{head} says that {said} is held, by the events it is {truth}: the file is damaged, plan again."
        )
    for pair in (*segment.may_touch, *segment.at_rest):
        if handled.isdisjoint(pair):
            raise FileError(f"{head} lets '{pair[0]}' touch '{pair[1]}', and neither is picked: plan again.")


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

    def checker(self, allowed: Iterable[tuple[str, str]]) -> CollisionChecker:
        """A checker of what there is now, where these pairs of names may touch besides."""
        robot = self.robot if self.held is None else with_carried(self.robot, [self.held])
        there = replace(self.scene, allowed=self.scene.allowed | {frozenset(pair) for pair in allowed})
        return type(self._known)(self._known.world.among(there, robot), self._known)

    def pose(self, name: str, q: Floats) -> Floats:
        """Where an object is (4, 4) in a configuration (dof,)."""
        if self.held is not None and self.held.name == name:
            return placement_of(self.held, self.robot, q)
        return next(item for item in self.scene.obstacles if item.name == name).placement

    def after(self, event: Event, q: Floats) -> None:
        """Take or let go, in a configuration (dof,); :class:`FileError` for what is not there."""
        name, held = event.object, self.held
        if event.kind == "attach":
            item = next((item for item in self.scene.obstacles if item.name == name), None)
            if item is None:
                raise FileError(
                    f"the task takes '{name}', which is not in scene '{self.scene.name}': give its --scene."
                )
            _require_there(event, item.placement, f"in scene '{self.scene.name}'")
            self.scene, self._name = taken(self.scene, item, self.robot, event.link, q), name
        elif event.kind == "detach":
            if held is None or held.name != name:
                raise FileError(f"the task lets go of '{name}', which it does not hold: mend the file.")
            _require_there(event, self.pose(name, q), "in the hand")
            self.scene, self._name = let_go(self.scene, held, self.robot, q), None


def _require_there(event: Event, placement: Floats, where: str) -> None:
    """Raise :class:`FileError` where an object is elsewhere than the plan had it."""
    if event.position is None or event.quaternion is None:
        return
    planned = pose(event.position, quaternion=event.quaternion)
    away = float(np.linalg.norm(placement[:3, 3] - planned[:3, 3]))
    turned = float(np.abs(placement[:3, :3] - planned[:3, :3]).max())
    if away > _MOVED or turned > _TURNED:
        off = f"{1e3 * away:.3g} mm and {turned:.2g} rad"
        raise FileError(
            f"at its {event.kind} '{event.object}' is {where} {off} from where the plan has it: plan again."
        )


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


def off_rest(made: Trajectory, path: Floats, part: str) -> Trajectory:
    """The part of a segment's motion that is farther from its rest than the corner next to that is."""
    leaves = part == "retreat"
    rest, corner = (path[0], path[1]) if leaves else (path[-1], path[-2])
    far = np.linalg.norm(made.knots() - rest, axis=1) >= np.linalg.norm(corner - rest)
    points = slice(int(np.argmax(far)), None) if leaves else slice(0, len(far) - int(np.argmax(far[::-1])))
    return Trajectory(made.joints, made.nanoseconds[points], tuple(rows[points] for rows in made.columns))


def summary(reports: list[tuple[SegmentRecord, Report]]) -> dict[str, Any]:
    """Whether all segments are as they should be, and each of them, as plain data."""
    found = [
        {
            "step": segment.step,
            "doing": segment.doing,
            "part": segment.part,
            "carried": segment.carried,
            "ok": report.ok,
            "contact": None if report.contact is None else str(report.contact.contact),
            "may_touch": [list(pair) for pair in segment.may_touch],
        }
        for segment, report in reports
    ]
    return {"ok": all(each["ok"] for each in found), "segments": found}
