"""A planned task checked by a replay of its events: what is held and what stands where follows from them alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pydantic

from planner.base.arrays import Floats
from planner.base.errors import FileError, choices
from planner.base.polynomials import evaluate
from planner.base.resolutions import RECHECK
from planner.base.yamlfile import Number
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.looks import looks_along, straight
from planner.kinematics.forward import tool_joint
from planner.problem.outcome import Outcome
from planner.query.in_hand import let_go, placement_of, taken
from planner.robot.poses import pose
from planner.robot.robot import Robot, with_carried, with_tool, without_carried
from planner.robot.shapes import Carried, Obstacle, extremes
from planner.tasks.candidates import RELEASE
from planner.tasks.modes import Pairs
from planner.tasks.sampling import gripper_of, place_at, standing
from planner.tasks.segments import Event, Segment
from planner.tasks.task import Gripper, TaskError
from planner.trajectory.check import check_path, check_trajectory
from planner.trajectory.recorded import require_of_an_arm
from planner.trajectory.report import Finding, Report
from planner.trajectory.trajectory import Trajectory

_SAME, _MOVED = 1e-6, 1e-3  # rad (m) between values in two files; m: an object so much elsewhere is held otherwise
_NEAR = RELEASE + 1e-4  # m, and the margin: so near its rest an object may touch what it stands on
_ORDERS = [], ["gripper", "attach"], ["detach", "gripper"]  # of events at the end of a segment


class TaskRecord(pydantic.BaseModel):
    """The part of a task's ``plan.json`` that a check needs."""

    outcome: str
    joints: list[str]
    path: list[list[Number]]
    segments: list[Segment]
    events: list[Event]


def check_task(
    record: TaskRecord, checker: CollisionChecker, whole: Trajectory | None, step: float = RECHECK
) -> Report:
    """The report on a task, with one part for each segment: its path and motion, its gripper, its releases.

    ``checker`` is of the scene before the task, ``whole`` the motion of all segments where there is one. Pairs that the
    record lets touch may do so if they are a hand and the object that it goes to or leaves, or an object near its rest
    and its support, as measured. Raises :class:`FileError` for a record that does not fit together.
    """
    _require_task(record, checker, whole)
    replay, parts = EventReplay(checker, record.events), list[Report]()
    motions, begun, path, rows = _motions_of(record, whole), None, None, list[list[float]]()
    for number, (segment, motion) in enumerate(zip(record.segments, motions, strict=True)):
        path = _path_of(f"segment {number + 1}", segment, motion, path, replay)
        events = [event for event in record.events if event.segment == number]
        following = next((event for event in events if event.kind != "gripper"), None)
        hand, rests, faults = replay.excuse_pairs(segment, path, begun, following)
        may_touch = hand.union(*rests.values())
        report = check_path(replay.checker(may_touch), path, step)
        if report.ok and motion is not None:
            report = check_trajectory(replay.checker(may_touch), motion, step=step)
        if report.ok and rests:
            faults += _find_contacts_off_rest(path, motion, replay, hand, rests, step)
        faults += _find_wrong_commands(events, replay.robot)
        rows += segment.path[len(rows) > 0 :].tolist()
        if segment is record.segments[-1] and record.path != rows:
            faults.append("the path of the task must be that of its segments: plan again")
        findings = (
            *report.findings,
            *(Finding("constraint", ("task",), (number, number), text=text) for text in faults),
        )
        labels = {name: getattr(segment, name) for name in ("step", "doing", "part", "carried")}
        labels["may_touch"] = sorted(map(sorted, may_touch))
        title = f"step {segment.step}, {segment.doing}: {segment.part}"
        parts.append(replace(report, findings=findings, measures=report.measures | labels, title=title))
        begun = following
        for event in events:
            replay.apply(event, path[-1])
    findings = tuple(finding for part in parts for finding in part.findings)
    return Report(checker, step, whole is not None, findings, parts=tuple(parts))


def _require(holds: object, text: str, remedy: str = "the files are damaged, plan again") -> None:
    if not holds:
        raise FileError(f"{text}: {remedy}.")


def _require_task(record: TaskRecord, checker: CollisionChecker, whole: Trajectory | None) -> None:
    """Raise :class:`FileError` for what is no solved task of this robot with one path and the events of its motion."""
    events, joints, count = [event.to_dict() for event in record.events], checker.robot.joints, len(record.segments)
    same = whole is None or [dict(event) for event in whole.events] == events
    _require(same, "the task has other events than its trajectory")
    solved = record.outcome == Outcome.SOLVED.key and count
    _require(solved, f"a task must be solved, got '{record.outcome}', {count} segments", "plan again")
    late = any(event.segment >= count for event in record.events)
    _require(not late, "an event of the task comes after a segment that is not there")
    same = tuple(record.joints) == joints and (whole is None or whole.joints == joints)
    _require(same, f"joints of the task and its trajectory must be {choices(joints)} in this order", "plan again")


def _path_of(
    head: str, segment: Segment, motion: Trajectory | None, before: Floats | None, replay: EventReplay
) -> Floats:
    """The path of a segment; :class:`FileError` where it does not follow from the one before it and from the events."""
    path, robot, held = segment.path, replay.robot, replay.held and replay.held.name
    _require(path.shape[1] == robot.dof, f"{head} has {path.shape[1]} columns, {robot.name} has {robot.dof} joints")
    require_of_an_arm(path, robot, head)
    _require(len(path) > 1, f"{head} has a path of one waypoint")
    joins = before is None or np.abs(path[0] - before[-1]).max() <= _SAME
    _require(joins, f"{head} begins elsewhere than the one before it ends")
    joins = motion is None or np.abs(motion.columns[0][[0, -1]] - path[[0, -1]]).max() <= _SAME
    _require(joins, f"{head} of the task has another path than its trajectory")
    said, truth = (f"'{name}'" if name else "nothing" for name in (segment.carried, held))
    _require(segment.carried == held, f"{head} says that {said} is held, by the events it is {truth}")
    return path


def _motions_of(record: TaskRecord, whole: Trajectory | None) -> list[Trajectory | None]:
    """The part of the whole motion that each segment is; :class:`FileError` where it moves, or events come, outside."""
    if whole is None:
        return [None] * len(record.segments)
    edges, clock, motions = [int(whole.nanoseconds[0])], whole.nanoseconds, list[Trajectory | None]()
    for segment in record.segments:
        times = segment.trajectory
        if times is None:
            raise FileError("the task has a trajectory, and segments without times: the files are damaged, plan again.")
        edges += [round(times.begin * 1e9), round((times.begin + times.duration) * 1e9)]
        rows = np.flatnonzero((clock >= edges[-2]) & (clock <= edges[-1]))
        _require(len(rows) > 1, "the segments of the task have other times than its trajectory")
        columns = tuple(column[rows] for column in whole.columns)
        motions.append(Trajectory(whole.joints, clock[rows], columns, whole.law, whole.limits))
    for number, (end, begin) in enumerate(zip(edges[::2], [*edges[1::2], int(clock[-1])], strict=True)):
        rows, h = (clock >= end) & (clock <= begin), 1e-9 * (begin - end)
        where = f"after segment {number}" if number else "before its first segment"
        _require(rows.any(), f"the trajectory of the task has other times {where} than its segments")
        rates = sum(np.abs(rate[rows]).max() * h**k for k, rate in enumerate(whole.columns) if k)
        still = max(rates, np.ptp(whole.columns[0][rows], axis=0).max()) <= _SAME
        _require(still, f"the trajectory of the task moves on {where}")
        moments = [event.t for event in record.events if event.segment == number - 1]
        between = all(t is not None and end - 1 <= 1e9 * t <= begin + 1 for t in moments)
        _require(between, f"an event of the task does not come {where}, where it belongs")
    return motions


def _find_wrong_commands(events: Sequence[Event], robot: Robot) -> Iterator[str]:
    """Yield faults of the gripper's commands at the end of a segment; a robot without fingers needs none."""
    kinds = [event.kind for event in events if event.kind != "gripper" or event.joints]
    if kinds not in _ORDERS and ("gripper" in kinds or gripper_of(robot, Gripper()).closed):
        yield f"events at its end must be gripper, attach or detach, gripper; got {', '.join(kinds)}: plan again"
    for event in events:
        try:
            gripper_of(robot, Gripper(open=event.joints or {}))
        except TaskError as error:
            yield str(error)


def _find_contacts_off_rest(
    path: Floats, motion: Trajectory | None, replay: EventReplay, hand: Pairs, rests: dict[int, Pairs], step: float
) -> Iterator[str]:
    """Yield the first contact on path and motion off the rest of the held object that is excused at its rest only."""
    strict, held = second_checker(replay.checker(hand)), replay.held
    assert held is not None
    for pieces in (straight(path[:-1], np.diff(path, axis=0)), *(() if motion is None else (motion.coefficients,))):
        looks = looks_along(strict, pieces, step)
        q = evaluate(pieces[looks.piece], looks.s)
        at = np.array([replay.pose(held.name, row) for row in q])
        off = np.min([_measure_shift(held, at, replay.pose(held.name, path[row])) for row in rests], axis=0)
        far = off > _NEAR + strict.world.margin
        if far.any() and (seen := strict.first_contact(q[far])):
            touch = f"{seen[1]} {seen[1].how(strict.world.margin)} {1e3 * off[far][seen[0]]:.3g} mm"
            yield f"{touch} off the rest of '{held.name}', they may within {1e3 * RELEASE:g} mm: plan again"


def _measure_shift(item: Carried | Obstacle, a: Floats, b: Floats) -> Floats:
    """How far (n,) m a point of an item at most is in placements ``a`` (n, 4, 4) from where it is in ``b`` (4, 4)."""
    points = np.where(np.indices((2, 2, 2)).reshape(3, 8).T, *reversed(extremes(item.shape)))
    return np.linalg.norm((a - b)[..., :3, :3] @ points.T + (a - b)[..., :3, 3:], axis=-2).max(axis=-1)


class EventReplay:
    """What stands where and what is held, event after event, from the scene of a ``checker`` before the task on.

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

    def checker(self, allowed: Pairs = frozenset(), with_held: bool = True) -> CollisionChecker:
        """A checker of what there is now, where these pairs of names may touch besides."""
        robot = with_carried(self.robot, [self.held]) if self.held is not None and with_held else self.robot
        there = replace(self.scene, allowed=self.scene.allowed | allowed)
        return type(self._known)(self._known.world.among(there, robot), self._known)

    def excuse_pairs(
        self, segment: Segment, path: Floats, begun: Event | None, following: Event | None
    ) -> tuple[Pairs, dict[int, Pairs], list[str]]:
        """Pairs of hand and object that may touch, pairs at a rest by its row of the path, and faults of a release."""
        declared = frozenset(frozenset(pair) for pair in (*segment.may_touch, *segment.at_rest))
        robot, held, hand, rests, found = self.robot, self.held, Pairs(), dict[int, Pairs](), list[str]()
        links = [body.link for body in robot.bodies if tool_joint(robot)[0] in robot.model.supports[body.joint]]
        for row, event in ((0, begun), (-1, following)):
            if event is not None and held is not None and held.name == event.object:
                item = Obstacle(held.name, held.shape, self.pose(held.name, path[row]))
                try:
                    place = (place_at if row else standing)(item, item.placement, self.checker(with_held=False))
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

    def apply(self, event: Event, q: Floats) -> None:
        """Take or let go, in a configuration (dof,); :class:`FileError` for an object that is not there."""
        if event.kind == "gripper":
            return
        name, held, takes = event.object, self.held, event.kind == "attach"
        where = f"in scene '{self.scene.name}'" if takes else "in the hand"
        _require(not takes or held is None, f"the task takes '{name}' while it holds '{self._name}'")
        there = self.scene.obstacles if takes else () if held is None else (held,)
        item = next((item for item in there if item.name == name), None)
        if item is None:
            raise FileError(f"the task {event.kind}es '{name}', which is not {where}: give the scene of the task.")
        if event.position is not None and event.quaternion is not None:
            planned = pose(event.position, quaternion=event.quaternion)
            away = float(_measure_shift(item, self.pose(name, q), planned))
            off = f"at its {event.kind} '{name}' is {where} {1e3 * away:.3g} mm from where the plan has it"
            _require(away <= _MOVED, off, "plan again")
        if isinstance(item, Carried):
            self.scene, self._name = let_go(self.scene, item, self.robot, q), None
            return
        with_hand = tool_joint(with_tool(self.robot, event.link))[0] == tool_joint(self.robot)[0]
        _require(with_hand, f"the task takes '{name}' with '{event.link}', which does not move with the tool")
        self.scene, self._name = taken(self.scene, item, self.robot, event.link, q), name
