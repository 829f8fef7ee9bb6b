"""``planner.check``: check a path, a trajectory, a file, a plan or a task of any origin.

For a task, a replay of its events alone determines the held object and the poses of all objects.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats, numbers
from planner.base.errors import FileError, OptionError, choices
from planner.base.files import StrPath
from planner.base.polynomials import evaluate
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import RECHECK
from planner.base.yamlfile import read_text, validate
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.recheck import sample_along, straight
from planner.kinematics.forward import tool_joint
from planner.planning.result import JSON_NAME, Plan
from planner.problem.options import AS_PLANNED, EMPTY, RobotLike, SceneLike
from planner.problem.outcome import Outcome
from planner.problem.request import LimitsRequest, PartialWorld, WorldRequest
from planner.query.query import make_checker_for
from planner.query.robots import attach_object, detach_object, placement_in_hand
from planner.roadmap.storage import read_world_request
from planner.robot.poses import pose
from planner.robot.robot import Robot, with_carried, with_tool, without_carried
from planner.robot.shapes import Carried, Obstacle, bounding_box
from planner.tasks.candidates import RELEASE
from planner.tasks.modes import Pairs
from planner.tasks.result import TaskPlan, TaskPlanRecord
from planner.tasks.sampling import complete_gripper, make_placement, place_at
from planner.tasks.segments import Event, Segment
from planner.tasks.task import Gripper, TaskError
from planner.tradeoff.record import SWEEP_NAME
from planner.trajectory.check import check_path, check_trajectory, require_step
from planner.trajectory.file import TRAJECTORY_NAME, parse_json
from planner.trajectory.limits import MotionLimits, require_within_robot
from planner.trajectory.recorded import FAR, read_motion, require_plausible
from planner.trajectory.report import Finding, Report
from planner.trajectory.trajectory import Trajectory

_SAME, _MOVED = 1e-6, 1e-3  # rad (m), tolerance of values in two files; m, of the pose of a grasped object
_NEAR = RELEASE + 1e-4  # m beyond the margin from its rest, where an object may touch its support
_ORDERS = [], ["gripper", "attach"], ["detach", "gripper"]  # orders of events at the end of a segment


def check(
    motion: Floats | Sequence[Sequence[float]] | Trajectory | StrPath | Plan | TaskPlan,
    *,
    robot: RobotLike | None = None,
    scene: SceneLike = AS_PLANNED,
    limits: MotionLimits | LimitsRequest | None = None,
    checker: CollisionChecker | None = None,
    step: float = RECHECK,
    progress: Progress = QUIET,
    **options: Any,
) -> Report:
    """Check a motion: a path (k, dof) in rad, a trajectory, a file or folder, a plan or a planned task.

        report = planner.check("out")
        report.ok, report.proven, report.sentence
        for finding in report.findings: print(finding.sentence)

    Samples are ``step`` metres of motion apart; proofs of polynomial pieces cover the states between them. ``robot``
    and ``scene`` are names, files or objects, ``options`` are other options of a world (``margin``, ``constraint``,
    ``tool`` ...); a file has default values in the plan.json next to it. ``checker`` replaces all of them. ``limits``
    replace those of a trajectory. Raises :class:`PlannerError` for an unreadable motion, and :class:`ArrayError` for an
    array of another shape.
    """
    require_step(step)
    given = PartialWorld(robot=robot, scene=EMPTY if scene is None else scene or None, **options)
    if isinstance(motion, str | os.PathLike):
        return check_file(Path(motion), given, limits, step, progress, checker)
    if isinstance(motion, Plan | TaskPlan) and given != PartialWorld():
        raise OptionError("robot and scene must be those of the plan: leave them out, or check its trajectory.")
    if isinstance(motion, TaskPlan):
        return check_task(motion, checker or motion.checker, motion.trajectory, step)
    if isinstance(motion, Plan):
        checker, motion = checker or motion.checker, motion.path if motion.trajectory is None else motion.trajectory
    checker = checker or make_checker_for(_with_config(given, {}))
    if isinstance(motion, Trajectory):
        return check_trajectory(checker, motion, _limits(limits, checker.robot), step, progress)
    return check_path(checker, numbers("path", motion, ("k", checker.robot.dof), most=FAR), step, progress)


def check_file(
    path: Path,
    given: PartialWorld,
    limits: MotionLimits | LimitsRequest | None = None,
    step: float = RECHECK,
    progress: Progress = QUIET,
    checker: CollisionChecker | None = None,
) -> Report:
    """Check a file or the folder of a plan; the plan.json next to it has default values for ``given``.

    Raises :class:`OptionError` for ``limits`` with a path without times, or with a task.
    """
    folder = path if os.path.isdir(path) else path.parent
    ours = os.path.isdir(path) or path.name in (JSON_NAME, TRAJECTORY_NAME)
    record = _read_record(folder) if ours or given.robot is None or given.scene is None else {}
    config = record.get("config", {})
    world = _with_config(given, config)
    if ours and "segments" in record:
        _require_without(limits, f"limits must be those of the task for {path}")
        return _check_task_in(folder, record, checker or make_checker_for(world), step)
    if os.path.isdir(path) and not os.path.isfile(path / TRAJECTORY_NAME) and record:
        if "intervals" in record:
            raise FileError(f"{path} must have one motion, got a sweep: name a file such as trajectory-1.json.")
        path = path / JSON_NAME
    read = cache(lambda robot: read_motion(path, robot, record if path.name == JSON_NAME and record else None))
    message = None if given.robot is not None and given.robot != config.get("robot") else config.get("request")
    checker = checker or make_checker_for(world, message, lambda checker: _start_of(read(checker.robot)))
    motion = read(checker.robot)
    if isinstance(motion, Trajectory):
        if limits is None and motion.limits is not None:
            require_within_robot(checker.robot, motion.limits)
        return check_trajectory(checker, motion, _limits(limits, checker.robot), step, progress)
    _require_without(limits, f"limits need a motion, {path} holds a path without times")
    return check_path(checker, motion, step, progress)


def _read_record(folder: Path) -> dict[str, Any]:
    """Read the plan.json or sweep.json of a folder; return an empty dict without one."""
    file = next((folder / name for name in (JSON_NAME, SWEEP_NAME) if os.path.isfile(folder / name)), None)
    if file is None:
        return {}
    record = parse_json(read_text(file, "plan"), f"plan {file}")
    return record if isinstance(record, dict) and isinstance(record.get("config", {}), dict) else {}


def _with_config(given: PartialWorld, config: Mapping[str, Any]) -> WorldRequest:
    """Return the world of ``given``, completed by the ``config`` of a plan.json.

    From the config of another robot only scene, margin and constraints are used.
    """
    options = {name: value for name, value in config.items() if value is not None}
    if given.robot is not None and given.robot != config.get("robot"):
        options = {name: options[name] for name in ("scene", "margin", "constraint") if name in options}
    if given.group is not None or given.joints is not None:
        options = {name: value for name, value in options.items() if name not in ("group", "joints")}
    own = {each.name: getattr(given, each.name) for each in fields(given)}  # type: ignore[arg-type]
    own = {name: value for name, value in own.items() if value not in (None, ())}
    return replace(read_world_request(options, "next to it"), **own)


def _check_task_in(folder: Path, data: dict[str, Any], checker: CollisionChecker, step: float) -> Report:
    """Check the task whose plan.json holds ``data``, with the motion next to it."""
    record, joints = validate(TaskPlanRecord, data, f"plan {folder / JSON_NAME}"), checker.robot.joints
    timed = any(segment.trajectory for segment in record.segments) or os.path.isfile(folder / TRAJECTORY_NAME)
    whole = Trajectory.load(folder / TRAJECTORY_NAME) if timed else None
    solved, count = record.outcome == Outcome.SOLVED.key, len(record.segments)
    _require(solved and count, f"a task must be solved, got '{record.outcome}', {count} segments", "plan again")
    same = tuple(record.joints) == joints and (whole is None or whole.joints == joints)
    _require(same, f"joints of the task and its trajectory must be {choices(joints)} in this order", "plan again")
    if whole is not None and whole.limits is not None:
        require_within_robot(checker.robot, whole.limits)
    return check_task(record, checker, whole, step)


def _start_of(motion: Floats | Trajectory) -> Floats:
    return motion.columns[0][0] if isinstance(motion, Trajectory) else motion[0]


def _limits(limits: MotionLimits | LimitsRequest | None, robot: Robot) -> MotionLimits | None:
    return MotionLimits.from_robot(robot, limits) if isinstance(limits, LimitsRequest) else limits


def _require_without(limits: MotionLimits | LimitsRequest | None, why: str) -> None:
    """Raise :class:`OptionError` with the reason ``why`` if limits are given."""
    if limits is not None:
        raise OptionError(f"{why}: leave --limits, --velocity-scale, --acceleration, --jerk and their like out.")


def check_task(
    plan: TaskPlan | TaskPlanRecord, checker: CollisionChecker, whole: Trajectory | None, step: float = RECHECK
) -> Report:
    """Check a task, with one partial report per segment: its path and motion, its gripper, its releases.

    ``checker`` is of the scene before the task, ``whole`` the motion of all segments, if any. The contacts of the plan
    are allowed between a hand and the object that it picks or places, and between an object near its rest and its
    support. Raises :class:`FileError` for an inconsistent plan.
    """
    _require(plan.segments, "a task must be solved, got no segments", "plan again")
    motions, replay, reports = _motions_of(plan, whole), _Replay(checker, plan.events), list[Report]()
    begun, before, rows = None, None, list[list[float]]()
    for number, (segment, motion) in enumerate(zip(plan.segments, motions, strict=True)):
        _require_path(f"segment {number + 1}", segment, motion, before, replay)
        events, before = [event for event in plan.events if event.segment == number], segment.path
        following = next((event for event in events if event.kind != "gripper"), None)
        hand, rests, faults = replay.excuse_pairs(segment, begun, following)
        may_touch = hand.union(*rests.values())
        report = check_path(replay.checker(may_touch), segment.path, step)
        if report.ok and motion is not None:
            report = check_trajectory(replay.checker(may_touch), motion, step=step)
        if report.ok and rests:
            faults += _find_contacts_off_rest(segment.path, motion, replay, hand, rests, step)
        faults += _find_wrong_commands(events, replay.robot)
        rows += segment.path[len(rows) > 0 :].tolist()
        if number == len(plan.segments) - 1 and np.asarray(plan.path, dtype=object).tolist() != rows:
            faults.append("the path of the task must be that of its segments: plan again")
        findings = tuple(Finding("constraint", ("task",), (number, number), text=text) for text in faults)
        labels = {name: getattr(segment, name) for name in ("step", "doing", "part", "carried")}
        labels["may_touch"] = sorted(map(sorted, may_touch))
        title, measures = f"step {segment.step}, {segment.doing}: {segment.part}", report.measures | labels
        reports.append(replace(report, findings=report.findings + findings, measures=measures, title=title))
        begun = following
        for event in events:
            replay.apply(event, segment.path[-1])
    findings = tuple(finding for report in reports for finding in report.findings)
    return Report(checker, step, whole is not None, findings, parts=tuple(reports))


def _require(holds: object, text: str, remedy: str = "the files are damaged, plan again") -> None:
    if not holds:
        raise FileError(f"{text}: {remedy}.")


def _require_path(
    head: str, segment: Segment, motion: Trajectory | None, before: Floats | None, replay: _Replay
) -> None:
    """Raise :class:`FileError` for a path that does not continue ``before``, or contradicts events."""
    path, robot, held = segment.path, replay.robot, replay.held and replay.held.name
    _require(path.shape[1] == robot.dof, f"{head} has {path.shape[1]} columns, {robot.name} has {robot.dof} joints")
    require_plausible(path, robot, head)
    _require(len(path) > 1, f"{head} has a path of one waypoint")
    joins = before is None or np.abs(path[0] - before[-1]).max() <= _SAME
    _require(joins, f"{head} must begin at the end of the one before it")
    joins = motion is None or np.abs(motion.columns[0][[0, -1]] - path[[0, -1]]).max() <= _SAME
    _require(joins, f"{head} of the task must have the path of its trajectory")
    stated, actual = (f"'{name}'" if name else "nothing" for name in (segment.carried, held))
    _require(stated == actual, f"{head} must hold {actual} by the events, got {stated}")


def _motions_of(plan: TaskPlan | TaskPlanRecord, whole: Trajectory | None) -> Sequence[Trajectory | None]:
    """Return the motion of each segment; :class:`FileError` for motion or events outside of segments."""
    last = max((event.segment for event in plan.events), default=0)
    _require(last < len(plan.segments), "events of the task must follow its segments")
    if whole is None:
        return [None] * len(plan.segments)
    same = [dict(event) for event in whole.events] == [event.to_dict() for event in plan.events]
    _require(same, "the task must have the events of its trajectory")
    edges, clock, motions = [int(whole.nanoseconds[0])], whole.nanoseconds, list[Trajectory]()
    for segment in plan.segments:
        times = segment.trajectory
        if times is None:
            raise FileError("segments of the task must have times: the files are damaged, plan again.")
        edges += [round(times.begin * 1e9), round((times.begin + times.duration) * 1e9)]
        rows = np.flatnonzero((clock >= edges[-2]) & (clock <= edges[-1]))
        _require(len(rows) > 1, "segments of the task must have the times of its trajectory")
        columns = tuple(column[rows] for column in whole.columns)
        motions.append(Trajectory(whole.joints, clock[rows], columns, whole.time_law, whole.limits))
    for number, (end, begin) in enumerate(zip(edges[::2], [*edges[1::2], int(clock[-1])], strict=True)):
        rows, h = (clock >= end) & (clock <= begin), 1e-9 * (begin - end)
        where = f"after segment {number}" if number else "before its first segment"
        _require(rows.any(), f"the trajectory of the task must have the times of its segments {where}")
        rates = sum(np.abs(rate[rows]).max() * h**k for k, rate in enumerate(whole.columns) if k)
        still = max(rates, np.ptp(whole.columns[0][rows], axis=0).max()) <= _SAME
        _require(still, f"the trajectory of the task must be at rest {where}")
        moments = [event.t for event in plan.events if event.segment == number - 1]
        between = all(t is not None and end - 1 <= 1e9 * t <= begin + 1 for t in moments)
        _require(between, f"events of the task must be at their times {where}")
    return motions


def _find_wrong_commands(events: Sequence[Event], robot: Robot) -> Iterator[str]:
    """Yield faults of the gripper's commands at the end of a segment; without fingers none is needed."""
    kinds = [event.kind for event in events if event.kind != "gripper" or event.joints]
    if kinds not in _ORDERS and ("gripper" in kinds or complete_gripper(robot, Gripper()).closed):
        yield f"events at its end must be gripper, attach or detach, gripper; got {', '.join(kinds)}: plan again"
    for event in events:
        try:
            complete_gripper(robot, Gripper(open=event.joints or {}))
        except TaskError as error:
            yield str(error)


def _find_contacts_off_rest(
    path: Floats, motion: Trajectory | None, replay: _Replay, hand: Pairs, rests: dict[int, Pairs], step: float
) -> Iterator[str]:
    """Yield the first contact, off the rest, of a pair that may touch at the rest only."""
    strict, held = second_checker(replay.checker(hand)), replay.held
    assert held is not None
    for pieces in (straight(path[:-1], np.diff(path, axis=0)), *(() if motion is None else (motion.coefficients,))):
        looks = sample_along(strict, pieces, step)
        q = evaluate(pieces[looks.piece], looks.s)
        at = np.array([replay.pose(held.name, row) for row in q])
        off = np.min([_measure_shift(held, at, replay.pose(held.name, path[row])) for row in rests], axis=0)
        far = off > _NEAR + strict.world.margin
        if far.any() and (hit := strict.first_contact(q[far])):
            touch = f"{hit[1]} {hit[1].how(strict.world.margin)} {1e3 * off[far][hit[0]]:.3g} mm"
            yield f"{touch} off the rest of '{held.name}', at most {1e3 * RELEASE:g} mm are allowed: plan again"


def _measure_shift(item: Carried | Obstacle, a: Floats, b: Floats) -> Floats:
    """Return the largest shift (n,) m of an item's points between ``a`` (n, 4, 4) and ``b`` (4, 4)."""
    points = np.where(np.indices((2, 2, 2)).reshape(3, 8).T, *reversed(bounding_box(item.shape)))
    return np.linalg.norm((a - b)[..., :3, :3] @ points.T + (a - b)[..., :3, 3:], axis=-2).max(axis=-1)


class _Replay:
    """The scene and the held object after each event, from the scene of a ``checker`` before the task.

    A carried object of the scene is held by the task if the first event releases it.
    """

    def __init__(self, checker: CollisionChecker, events: Sequence[Event]) -> None:
        self._known, self.scene = checker, checker.world.scene
        first = next((event for event in events if event.kind != "gripper"), None)
        self._name = first.object if first is not None and first.kind == "detach" else None
        self.robot = checker.robot if self.held is None else without_carried(checker.robot, self.held.name)

    @property
    def held(self) -> Carried | None:
        """The object that the task holds; other carried objects belong to the robot."""
        return next((item for item in self.scene.carried if item.name == self._name), None)

    def checker(self, allowed: Pairs = frozenset(), with_held: bool = True) -> CollisionChecker:
        """Return the checker of the current scene, with more allowed contacts."""
        robot = with_carried(self.robot, [self.held]) if self.held is not None and with_held else self.robot
        scene = replace(self.scene, allowed=self.scene.allowed | allowed)
        return type(self._known)(self._known.world.among(scene, robot), self._known)

    def excuse_pairs(
        self, segment: Segment, begun: Event | None, following: Event | None
    ) -> tuple[Pairs, dict[int, Pairs], list[str]]:
        """Return pairs of hand and object that may touch, pairs at a rest by row of the path, and faults."""
        declared = frozenset(frozenset(pair) for pair in (*segment.may_touch, *segment.at_rest))
        robot, held, hand, rests, faults = self.robot, self.held, Pairs(), dict[int, Pairs](), list[str]()
        links = [body.link for body in robot.bodies if tool_joint(robot)[0] in robot.model.supports[body.joint]]
        for row, event in ((0, begun), (-1, following)):
            if event is not None and held is not None and held.name == event.object:
                item = Obstacle(held.name, held.shape, self.pose(held.name, segment.path[row]))
                try:
                    rest = (place_at if row else make_placement)(item, item.placement, self.checker(with_held=False))
                    rests[row] = declared & {frozenset((held.name, on)) for on in rest.supports}
                except TaskError as error:
                    faults.append(str(error))
            elif event is not None:
                hand |= declared & {frozenset((event.object, link)) for link in links}
        return hand, rests, faults

    def pose(self, name: str, q: Floats) -> Floats:
        """Return the pose (4, 4) of an object in a configuration (dof,)."""
        if self.held is not None and self.held.name == name:
            return placement_in_hand(self.held, self.robot, q)
        return next(item for item in self.scene.obstacles if item.name == name).placement

    def apply(self, event: Event, q: Floats) -> None:
        """Attach or detach an object in a configuration (dof,); :class:`FileError` for a missing object."""
        if event.kind == "gripper":
            return
        name, held, takes = event.object, self.held, event.kind == "attach"
        where = f"in scene '{self.scene.name}'" if takes else "in the hand"
        _require(not takes or held is None, f"the hand must be empty to pick '{name}', got '{self._name}'")
        choice = self.scene.obstacles if takes else () if held is None else (held,)
        item = next((item for item in choice if item.name == name), None)
        if item is None:
            raise FileError(f"object '{name}' to {event.kind} not found {where}: give the scene of the task.")
        if event.position is not None and event.quaternion is not None:
            planned = pose(event.position, quaternion=event.quaternion)
            away = float(_measure_shift(item, self.pose(name, q), planned))
            off = f"at its {event.kind} '{name}' is {where} {1e3 * away:.3g} mm from where the plan has it"
            _require(away <= _MOVED, off, "plan again")
        if isinstance(item, Carried):
            self.scene, self._name = detach_object(self.scene, item, self.robot, q), None
            return
        with_hand = tool_joint(with_tool(self.robot, event.link))[0] == tool_joint(self.robot)[0]
        _require(with_hand, f"the link that picks '{name}' must move with the tool, got '{event.link}'")
        self.scene, self._name = attach_object(self.scene, item, self.robot, event.link, q), name
