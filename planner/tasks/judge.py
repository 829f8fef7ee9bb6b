"""A planned task checked whole, from its record alone: where everything is follows from the events."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from planner.base.arrays import Floats, frozen
from planner.base.errors import FileError
from planner.base.files import is_file, is_folder
from planner.base.yamlfile import read_text, validate
from planner.collision.checker import CollisionChecker
from planner.collision.self_pairs import disabled_pairs
from planner.collision.world import World
from planner.kinematics.forward import tool_pose
from planner.models.robot import with_carried, with_tool, without_carried
from planner.models.shapes import Carried, Obstacle
from planner.paths.check import PathReport
from planner.paths.file import matrix, parse
from planner.planning.result import JSON_NAME
from planner.tasks.record import Event, SegmentRecord, SegmentTimes
from planner.trajectory.check import TrajectoryReport, check, looked_at
from planner.trajectory.trajectory import Trajectory

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
    stage = Stage(checker, record.events)
    for number, segment in enumerate(record.segments):
        path = matrix(segment.path, f"segment {number + 1}")
        if path.shape[1] != stage.robot.dof:
            raise FileError(
                f"segment {number + 1} has {path.shape[1]} columns, {stage.robot.name} has {stage.robot.dof} joints."
            )
        made = None if whole is None or segment.trajectory is None else _part(whole, segment.trajectory)
        touching = [*segment.may_touch, *segment.at_rest]
        report = check(path if made is None else made, stage.checker(touching), step)
        if isinstance(report, TrajectoryReport) and segment.at_rest and report.contact is None and made is not None:
            contact = looked_at(off_rest(made, path, segment.part), stage.checker(segment.may_touch), step)
            report = replace(report, contact=contact)
        yield segment, report
        for event in (each for each in record.events if each.segment == number):
            stage.after(event, path[-1])


class Stage:
    """What stands where and what is held, event after event: the scene of a ``checker`` before the task at first.

    What the scene lets the arm carry, and the first event lets go of, is held at the beginning.
    """

    def __init__(self, checker: CollisionChecker, events: Sequence[Event]) -> None:
        self._base, self.scene = checker.world, checker.world.scene
        self._known, self._disabled = checker, disabled_pairs(checker.robot, type(checker))
        self.standing = {item.name: item for item in self.scene.obstacles}
        first = next((event for event in events if event.kind != "gripper"), None)
        name = first.object if first is not None and first.kind == "detach" else None
        self.held = next((item for item in self.scene.carried if item.name == name), None)
        self.robot = checker.robot if self.held is None else without_carried(checker.robot, self.held.name)

    def checker(self, allowed: Iterable[tuple[str, str]]) -> CollisionChecker:
        """A checker of what there is now, where these pairs of names may touch besides."""
        pairs = self.scene.allowed | {frozenset(pair) for pair in allowed}
        robot = self.robot if self.held is None else with_carried(self.robot, [self.held])
        there = replace(self.scene, obstacles=tuple(self.standing.values()), allowed=pairs)
        disabled = self._disabled | robot.touching
        world = World.of(robot, there, disabled, self._base.margin, self._base.conditions)
        return type(self._known)(world, self._known)

    def pose(self, name: str, q: Floats) -> Floats:
        """Where an object is (4, 4) in a configuration (dof,)."""
        if self.held is None or self.held.name != name:
            return self.standing[name].placement
        return self._hand(self.held.link, q) @ self.held.placement

    def after(self, event: Event, q: Floats) -> None:
        """Take or let go, in a configuration (dof,); :class:`FileError` for what is not there."""
        name, held = event.object, self.held
        if event.kind == "attach":
            if name not in self.standing:
                raise FileError(
                    f"the task takes '{name}', which is not in scene '{self.scene.name}': give its --scene."
                )
            item = self.standing.pop(name)
            pose = frozen(np.linalg.inv(self._hand(event.link, q)) @ item.placement)
            self.held = Carried(event.link, name, item.shape, pose)
        elif event.kind == "detach":
            if held is None or held.name != name:
                raise FileError(f"the task lets go of '{name}', which it does not hold: mend the file.")
            self.standing[name], self.held = Obstacle(name, held.shape, frozen(self.pose(name, q))), None

    def _hand(self, link: str, q: Floats) -> Floats:
        return tool_pose(with_tool(self.robot, link), q).homogeneous


def _part(whole: Trajectory, times: SegmentTimes) -> Trajectory:
    """The part of a motion that a segment is."""
    begin, end = round(times.begin * 1e9), round((times.begin + times.duration) * 1e9)
    rows = np.flatnonzero((whole.nanoseconds >= begin) & (whole.nanoseconds <= end))
    if len(rows) < 2:
        raise FileError("the segments of the task have other times than its trajectory: plan again.")
    columns = tuple(column[rows] for column in whole.columns)
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
        }
        for segment, report in reports
    ]
    return {"ok": all(each["ok"] for each in found), "segments": found}
