"""A planned task checked whole, from its record alone: where everything is follows from the events."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from planner.base.arrays import Floats, frozen
from planner.base.errors import FileError
from planner.base.files import is_file, is_folder
from planner.base.yamlfile import Name, Number, read_text, validate
from planner.collision.checker import CollisionChecker
from planner.collision.self_pairs import generate_disabled_pairs
from planner.collision.world import World
from planner.kinematics.forward import tool_pose
from planner.models.robot import Robot, with_carried, with_tool
from planner.models.scene import Scene
from planner.models.shapes import Carried
from planner.paths.check import PathReport
from planner.paths.file import matrix, parse
from planner.planning.result import JSON_NAME
from planner.trajectory.check import TrajectoryReport, check, looked_at
from planner.trajectory.trajectory import Trajectory

Report = PathReport | TrajectoryReport


class _Part(pydantic.BaseModel):
    model_config = pydantic.ConfigDict(frozen=True, allow_inf_nan=False)


class _Times(_Part):
    begin: Number
    duration: Number


class SegmentRecord(_Part):
    """A segment as ``plan.json`` has it."""

    step: int
    doing: str
    part: str
    carried: Name | None
    may_touch: list[tuple[Name, Name]]
    at_rest: list[tuple[Name, Name]]
    path: list[list[Number]] = pydantic.Field(min_length=1)
    trajectory: _Times | None


class _Event(_Part):
    kind: str
    object: Name
    link: Name
    segment: int


class TaskRecord(_Part):
    """What a check needs of a task's ``plan.json``."""

    segments: list[SegmentRecord]
    events: list[_Event]


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
    robot, scene, disabled = checker.robot, checker.world.scene, checker.robot.disabled_pairs
    if disabled is None:
        disabled = generate_disabled_pairs(robot, type(checker))
    poses: dict[str, Floats] = {item.name: item.placement for item in scene.obstacles}
    held: Carried | None = None
    for number, segment in enumerate(record.segments):
        path = matrix(segment.path, f"segment {number + 1}")
        if path.shape[1] != robot.dof:
            raise FileError(f"segment {number + 1} has {path.shape[1]} columns, {robot.name} has {robot.dof} joints.")

        def there(allowed: list[tuple[str, str]], held: Carried | None = held) -> CollisionChecker:
            return _world(checker, disabled, poses, held, allowed)

        made = None if whole is None or segment.trajectory is None else _part(whole, segment.trajectory)
        report = check(path if made is None else made, there([*segment.may_touch, *segment.at_rest]), step)
        if isinstance(report, TrajectoryReport) and segment.at_rest and report.contact is None and made is not None:
            contact = looked_at(off_rest(made, path, segment.part), there(segment.may_touch), step)
            report = replace(report, contact=contact)
        yield segment, report
        for event in (each for each in record.events if each.segment == number and each.kind != "gripper"):
            held = _after(event, path[-1], robot, scene, poses, held)


def _world(
    checker: CollisionChecker,
    disabled: frozenset[frozenset[str]],
    poses: dict[str, Floats],
    held: Carried | None,
    allowed: list[tuple[str, str]],
) -> CollisionChecker:
    robot, scene, margin = checker.robot, checker.world.scene, checker.world.margin
    obstacles = tuple(replace(o, placement=poses[o.name]) for o in scene.obstacles if not held or o.name != held.name)
    pairs = scene.allowed | {frozenset(pair) for pair in allowed}
    holding = robot if held is None else with_carried(robot, [held])
    there = replace(scene, obstacles=obstacles, allowed=pairs)
    return type(checker)(
        World.of(holding, there, disabled | holding.touching, margin, checker.world.conditions), checker
    )


def _after(
    event: _Event, q: Floats, robot: Robot, scene: Scene, poses: dict[str, Floats], held: Carried | None
) -> Carried | None:
    """What is held after an event; ``poses`` are brought up to date."""
    tool = tool_pose(with_tool(robot, event.link), q).homogeneous
    if event.kind == "attach":
        item = next((each for each in scene.obstacles if each.name == event.object), None)
        if item is None:
            raise FileError(f"the task takes '{event.object}', which is not in scene '{scene.name}': give its --scene.")
        return Carried(event.link, item.name, item.shape, frozen(np.linalg.inv(tool) @ poses[item.name]))
    if held is None or held.name != event.object:
        raise FileError(f"the task lets go of '{event.object}', which it does not hold: mend the file.")
    poses[held.name] = frozen(tool @ held.placement)
    return None


def _part(whole: Trajectory, times: _Times) -> Trajectory:
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
