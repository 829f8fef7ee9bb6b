"""From the path through all modes to segments between rests, a motion for each, the events, and one motion of all."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, get_args

import numpy as np

from planner.base.arrays import Floats, Ints, frozen
from planner.collision.edge_prover import EdgeProver
from planner.cost.motion_cost import MotionCost
from planner.planning.motion import looked_at_again
from planner.problem.objective import Objective
from planner.problem.request import TimingRequest
from planner.robot.poses import quaternion_of
from planner.tasks.file import Move, Pick
from planner.tasks.modes import Mode
from planner.tasks.network import APPROACH, TaskNetwork
from planner.tasks.options import Options
from planner.tasks.record import Event, Part, SegmentRecord, SegmentTimes
from planner.tasks.why import doing
from planner.trajectory.limits import MotionLimits
from planner.trajectory.proof import prove_motion
from planner.trajectory.timing import timed_curve
from planner.trajectory.trajectory import Trajectory

PAUSE = 0.5  # s that the arm rests while a gripper moves
PARTS: tuple[Part, ...] = get_args(Part)


@dataclass(frozen=True, eq=False)
class Segment:
    """A stretch from rest to rest in one mode: ``path`` (k, dof), and where times were asked for its ``trajectory``.

    ``step`` counts from 1; ``part`` is transit, approach or retreat, ``carried`` what is held. Along the straight lines
    to and from a rest the object may touch what it stands on in ``mode``; off the rest
    (:func:`off_rest`) the segment is free in the mode ``strict`` too, where it may not.
    """

    step: int
    doing: str
    part: Part
    carried: str | None
    mode: Mode
    strict: Mode
    path: Floats
    trajectory: Trajectory | None = None

    def record(self, begin: float) -> SegmentRecord:
        """As ``plan.json`` has it; it begins at ``begin`` s of the whole."""
        made, pairs = self.trajectory, (self.strict.allowed, self.mode.allowed - self.strict.allowed)
        may_touch, at_rest = ([(min(pair), max(pair)) for pair in sorted(map(sorted, each))] for each in pairs)
        return SegmentRecord(
            step=self.step,
            doing=self.doing,
            part=self.part,
            carried=self.carried,
            may_touch=may_touch,
            at_rest=at_rest,
            path=self.path.tolist(),
            trajectory=None
            if made is None
            else SegmentTimes(begin=begin, duration=made.duration, law=made.law, proven=made.proven),
        )


def segments_of(options: Options, network: TaskNetwork, arcs: Ints) -> list[Segment]:
    """The stretches of a path between rests."""
    robot, motions = options.modes.robot, options.modes.motions
    found: list[Segment] = []
    for leg, group in itertools.groupby(arcs.tolist(), key=lambda arc: int(network.leg[arc])):
        rows = list(group)
        corners = [network.corners(motions, arc) for arc in rows]
        path = np.vstack([corners[0][:1], *(part[1:] for part in corners)])
        modes = [network.modes[network.mode[arc]] for arc in rows]
        loose = replace(modes[0], allowed=frozenset().union(*(mode.allowed for mode in modes)))
        strict = min(modes, key=lambda mode: len(mode.allowed))
        held = None if loose.held is None else options.modes.grasps[loose.held].object
        step, part = divmod(leg, 3)
        found.append(Segment(step + 1, doing(options.task.steps[step]), PARTS[part], held, loose, strict, path))
    if not found:
        return []
    paths = [segment.path for segment in found]
    unwound = np.split(robot.unwound(np.vstack(paths)), np.cumsum([len(path) for path in paths])[:-1])
    return [replace(segment, path=frozen(part)) for segment, part in zip(found, unwound, strict=True)]


def timed(
    segments: Sequence[Segment], options: Options, timing: TimingRequest, objective: Objective, scale: Any
) -> list[Segment]:
    """Each segment with the quickest motion from rest to rest; lines are kept but for their rounded corners.

    It is proven only if it is also free without what may touch at the rest, once it is off that.
    """
    robot = options.modes.robot
    limits = MotionLimits.of(robot, timing)
    cost = MotionCost(robot, scale, objective, longest=np.inf).of_pieces
    found = []
    for segment in segments:
        checker = options.modes.checker_of(segment.mode)
        line = segment.part != PARTS[0] and timing.time_law == "shortcuts"
        law = "blended" if line else timing.time_law
        made, _ = timed_curve(segment.path, checker, limits, law, 0.0, cost, timing.extra_cost)
        if segment.mode != segment.strict:
            strict = EdgeProver(options.modes.checker_of(segment.strict))
            away = off_rest(made, segment.path, segment.part)  # one point where the line ends so near its rest
            free = not len(away.seconds) or prove_motion(away, strict, limits).free
            made = replace(made, proven=made.proven and free, proof=made.proof | {"free_off_rest": free})
        found.append(replace(segment, trajectory=looked_at_again(made, checker)))
    return found


def off_rest(made: Trajectory, path: Floats, part: str) -> Trajectory:
    """The part of a segment's motion that is farther from its rest than the corner next to that is."""
    leaves = part == "retreat"
    rest, corner = (path[0], path[1]) if leaves else (path[-1], path[-2])
    far = np.linalg.norm(made.knots() - rest, axis=1) >= np.linalg.norm(corner - rest)
    points = slice(int(np.argmax(far)), None) if leaves else slice(0, len(far) - int(np.argmax(far[::-1])))
    return Trajectory(made.joints, made.nanoseconds[points], tuple(rows[points] for rows in made.columns))


def events_of(segments: Sequence[Segment], options: Options) -> tuple[Event, ...]:
    """What happens at the rests: the gripper closes and holds, or opens and lets go."""
    found: list[Event] = []
    t = 0.0 if all(segment.trajectory is not None for segment in segments) else None
    tool, gripper = options.modes.robot.tool, options.gripper
    for number, segment in enumerate(segments):
        if t is not None and segment.trajectory is not None:
            t += segment.trajectory.duration
        step = options.task.steps[segment.step - 1]
        if segment.part != PARTS[APPROACH] or isinstance(step, Move):
            continue
        pick = isinstance(step, Pick)
        held = segments[number + 1].mode.held if pick else segment.mode.held
        assert held is not None
        grasp = options.modes.grasps[held].grasp
        joints = gripper.values(grasp.opening) if pick else dict(gripper.open)
        wait = PAUSE if joints else 0.0
        now, kind = None if t is None else t + wait * pick, "attach" if pick else "detach"
        places = (options.modes.places[p] for p in segments[number if pick else number + 1].mode.standing)
        at = next(place.pose for place in places if place.object == step.object)
        stands = at[:3, 3].tolist(), quaternion_of(at[:3, :3])
        hold = Event(now, kind, step.object, tool, number, *stands)
        moves = [Event(t, "gripper", step.object, tool, number, joints=joints)] if joints else []
        found += [*moves, hold] if pick else [hold, *moves]
        t = None if t is None else t + wait
    return tuple(found)


def begins_of(segments: Sequence[Segment], events: Sequence[Event]) -> list[int]:
    """When (ns) each segment begins in the motion of all, which rests while a gripper moves."""
    waits, now, found = {event.segment for event in events if event.kind == "gripper"}, 0, []
    for number, segment in enumerate(segments):
        found.append(now)
        if segment.trajectory is not None:
            clock = segment.trajectory.nanoseconds
            now += int(clock[-1] - clock[0]) + (round(PAUSE * 1e9) if number in waits else 0)
    return found


def joined(segments: Sequence[Segment], events: Sequence[Event]) -> Trajectory | None:
    """One motion of all segments, that rests while a gripper moves; None where they have no times."""
    parts = [segment.trajectory for segment in segments]
    timed_parts = [part for part in parts if part is not None]
    if not timed_parts or len(timed_parts) < len(parts):
        return None
    begins, clock, columns = begins_of(segments, events), [], []
    for begin, part in zip(begins, timed_parts, strict=True):
        rows = slice(1 if clock and clock[-1][-1] == begin else 0, None)
        clock.append(part.nanoseconds[rows] - part.nanoseconds[0] + begin)
        columns.append([column[rows] for column in part.columns])
    whole = tuple(np.concatenate(column) for column in zip(*columns, strict=True))
    first = timed_parts[0]
    proven = all(part.proven for part in timed_parts)
    proof = {"segments": len(timed_parts), "segments_proven": sum(part.proven for part in timed_parts)}
    told = tuple(event.to_dict() for event in events)
    return Trajectory(first.joints, np.concatenate(clock), whole, first.law, first.limits, proven, proof, told)
