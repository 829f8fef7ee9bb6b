"""Split a path over modes into segments between rests, time each, and join motions and events."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import Field, GetPydanticSchema
from pydantic_core import core_schema

from planner.base.arrays import Floats, Ints, frozen, numbers
from planner.base.errors import FileError
from planner.base.yamlfile import Name, Number, Whole
from planner.collision.edge_prover import EdgeProver
from planner.cost.motion_cost import MotionCost
from planner.planning.solve import recheck
from planner.problem.outcome import Record
from planner.problem.request import Objective, TimingRequest
from planner.robot.poses import quaternion_of
from planner.tasks.candidates import Candidates
from planner.tasks.modes import Mode
from planner.tasks.network import APPROACH, TaskNetwork
from planner.tasks.task import Move, Pick, step_text
from planner.trajectory.limits import MotionLimits
from planner.trajectory.proof import prove_motion
from planner.trajectory.timing import time_curve
from planner.trajectory.trajectory import Trajectory

PAUSE = 0.5  # s at rest while a gripper moves
Part = Literal["transit", "approach", "retreat"]
PARTS: tuple[Part, ...] = get_args(Part)
TouchingPairs = list[tuple[Name, Name]]


@dataclass(frozen=True, kw_only=True, eq=False)
class SegmentTimes(Record):
    """Time of a segment in the joined motion."""

    begin: Number
    """s"""
    duration: Number
    """s"""
    time_law: str
    proven: bool


def _read_path(_: Any, handler: Any) -> core_schema.CoreSchema:
    rows = handler(Annotated[list[list[Number]], Field(min_length=1)])
    return core_schema.no_info_after_validator_function(
        lambda path: frozen(numbers("the path of a segment", path, ("k", "n"), FileError)), rows
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Segment(Record):
    """A path from rest to rest in one mode."""

    step: Whole
    """from 1"""
    doing: str
    """the step in words"""
    part: Part
    carried: Name | None
    """held object"""
    may_touch: TouchingPairs
    """allowed contacts along the path"""
    at_rest: TouchingPairs
    """contacts allowed at the rest only"""
    path: Annotated[Floats, GetPydanticSchema(_read_path)]
    """joint waypoints (k, dof), rad (m where a joint slides)"""
    trajectory: SegmentTimes | None
    """null without times"""

    def to_dict(self) -> dict[str, Any]:
        """Return the record as plain data."""
        return super().to_dict() | {"path": self.path.tolist()}


@dataclass(frozen=True)
class Event(Record):
    """An event at the end of a ``segment`` (from 0): a grasp, a release, or a motion of the gripper."""

    t: Number | None
    """s of the joined motion; null without times"""
    kind: Literal["attach", "detach", "gripper"]
    object: Name
    link: Name
    segment: Whole
    position: Annotated[list[Number], Field(min_length=3, max_length=3)] | None = None
    """m, of the object at an attach or detach event"""
    quaternion: Annotated[list[Number], Field(min_length=4, max_length=4)] | None = None
    """x, y, z, w, of the object"""
    joints: dict[str, Number] | None = None
    """target values of the gripper's joints, of a gripper event"""


def split_into_segments(candidates: Candidates, network: TaskNetwork, arcs: Ints) -> tuple[list[Segment], list[Mode]]:
    """Split a path into segments between rests; return them and their modes.

    On the lines to and from a rest the object may touch its support, but not off the rest (:func:`off_rest`).
    """
    robot, motions = candidates.modes.robot, candidates.modes.motions
    legs = [(leg, list(rows)) for leg, rows in itertools.groupby(arcs.tolist(), key=lambda arc: int(network.leg[arc]))]
    corners = [[network.corners(motions, arc) for arc in rows] for _, rows in legs]
    paths = [np.vstack([lines[0][:1], *(line[1:] for line in lines)]) for lines in corners]
    unwound = np.split(robot.unwound(np.vstack(paths)), np.cumsum([len(path) for path in paths])[:-1])
    segments, modes = [], []
    for (leg, rows), path in zip(legs, unwound, strict=True):
        allowed = [network.modes[network.mode[arc]].allowed for arc in rows]
        mode = replace(network.modes[network.mode[rows[0]]], allowed=frozenset().union(*allowed))
        strict = min(allowed, key=len)
        may_touch, at_rest = (
            [(min(pair), max(pair)) for pair in sorted(map(sorted, each))] for each in (strict, mode.allowed - strict)
        )
        step, part = divmod(leg, len(PARTS))
        segment = Segment(
            step=step + 1,
            doing=step_text(candidates.task.steps[step]),
            part=PARTS[part],
            carried=None if mode.held is None else candidates.modes.grasps[mode.held].object,
            may_touch=may_touch,
            at_rest=at_rest,
            path=frozen(path),
            trajectory=None,
        )
        segments.append(segment)
        modes.append(mode)
    return segments, modes


def time_segments(
    segments: Sequence[Segment],
    modes: Sequence[Mode],
    candidates: Candidates,
    timing: TimingRequest,
    objective: Objective,
    scale: Any,
) -> list[Trajectory]:
    """Time each segment from rest to rest; motions follow lines except at rounded corners.

    A motion is proven only if it is free without the contacts at its rest once it is off the rest.
    """
    robot = candidates.modes.robot
    limits = MotionLimits.from_robot(robot, timing)
    cost = MotionCost(robot, scale, objective, longest=np.inf).for_pieces
    trajectories = []
    for segment, mode in zip(segments, modes, strict=True):
        checker = candidates.modes.checker_of(mode)
        line = segment.part != PARTS[0] and timing.time_law == "shortcuts"
        time_law = "blended" if line else timing.time_law
        motion, _ = time_curve(segment.path, checker, limits, time_law, 0.0, cost, timing.extra_cost)
        if segment.at_rest:
            strict = candidates.modes.checker_of(replace(mode, allowed=frozenset(map(frozenset, segment.may_touch))))
            away = off_rest(motion, segment.path, segment.part)  # one point if the line is that short
            free = not len(away.seconds) or prove_motion(away, EdgeProver(strict), limits).free
            motion = replace(motion, proven=motion.proven and free, proof=motion.proof | {"free_off_rest": free})
        trajectories.append(recheck(motion, checker))
    return trajectories


def off_rest(motion: Trajectory, path: Floats, part: str) -> Trajectory:
    """Return the section of a segment's motion that is farther from its rest than the corner next to it."""
    leaves = part == "retreat"
    rest, corner = (path[0], path[1]) if leaves else (path[-1], path[-2])
    far = np.linalg.norm(motion.knots() - rest, axis=1) >= np.linalg.norm(corner - rest)
    points = slice(int(np.argmax(far)), None) if leaves else slice(0, len(far) - int(np.argmax(far[::-1])))
    return Trajectory(motion.joints, motion.nanoseconds[points], tuple(rows[points] for rows in motion.columns))


def join(
    segments: Sequence[Segment], modes: Sequence[Mode], motions: Sequence[Trajectory] | None, candidates: Candidates
) -> tuple[list[Segment], list[Event], Trajectory | None]:
    """Join motions of segments, at rest while a gripper moves; return segments, events and the motion.

    Without motions, times are None.
    """
    events = [_events_at(number, segments, modes, candidates) for number in range(len(segments))]
    if motions is None:
        return list(segments), list(itertools.chain(*events)), None
    begin, timed, joined_events, clock, columns = 0, list[Segment](), list[Event](), list[Ints](), []
    for segment, motion, rest in zip(segments, motions, events, strict=True):
        law, proven = motion.time_law, motion.proven
        times = SegmentTimes(begin=begin / 1e9, duration=motion.duration, time_law=law, proven=proven)
        timed.append(replace(segment, trajectory=times))
        rows = slice(1 if clock and clock[-1][-1] == begin else 0, None)
        clock.append(motion.nanoseconds[rows] - motion.nanoseconds[0] + begin)
        columns.append([column[rows] for column in motion.columns])
        begin = int(clock[-1][-1])
        for event in rest:  # a gripper closes before an attach event, and opens after a detach event
            joined_events.append(replace(event, t=begin / 1e9))
            begin += round(PAUSE * 1e9) if event.kind == "gripper" else 0
    joined = tuple(np.concatenate(column) for column in zip(*columns, strict=True))
    proof = {"segments": len(motions), "segments_proven": sum(motion.proven for motion in motions)}
    first, listed = motions[0], tuple(event.to_dict() for event in joined_events)
    proven = all(motion.proven for motion in motions)
    times = np.concatenate(clock)
    whole = Trajectory(first.joints, times, joined, first.time_law, first.limits, proven, proof, listed)
    return timed, joined_events, whole


def _events_at(
    number: int, segments: Sequence[Segment], modes: Sequence[Mode], candidates: Candidates
) -> Sequence[Event]:
    """Return the events at the end of a segment: the gripper closes and grasps, or opens and releases."""
    step, world = candidates.task.steps[segments[number].step - 1], candidates.modes
    if segments[number].part != PARTS[APPROACH] or isinstance(step, Move):
        return []
    pick, before, after = isinstance(step, Pick), modes[number], modes[number + 1]
    held = after.held if pick else before.held
    assert held is not None
    gripper, to = candidates.gripper, (step.object, world.robot.tool, number)
    joints = gripper.values(world.grasps[held].opening) if pick else dict(gripper.open or {})
    placements = (world.placements[k] for k in (before if pick else after).standing)
    at = next(each.pose for each in placements if each.object == step.object)
    stands = at[:3, 3].tolist(), quaternion_of(at[:3, :3])
    moves = [Event(None, "gripper", *to, joints=joints)] if joints else []
    return [*moves, Event(None, "attach", *to, *stands)] if pick else [Event(None, "detach", *to, *stands), *moves]
