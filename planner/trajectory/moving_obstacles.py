"""Proofs about a trajectory among moving obstacles: known motions, and a horizon for unknown ones."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, cumulative_sums
from planner.base.polynomials import part
from planner.collision import coal_checker
from planner.collision.checker import CollisionChecker
from planner.collision.coal import CoalInTime
from planner.collision.recheck import Clearance
from planner.collision.timed_prover import TimedProver, moving_world
from planner.collision.world import Contact
from planner.robot.moving import MovingObstacle
from planner.trajectory.trajectory import NANOSECOND, Trajectory

_HALVINGS = 12  # of the piece in which a horizon ends
_CUT = 7  # subintervals of an interval that needs finer samples
_BATCH = 2048  # moments per query


@dataclass(frozen=True, eq=False)
class TimeProof:
    """Proofs about a trajectory in time; the scene's times are those of the trajectory.

    ``free`` (k,) marks the pieces proven clear of the obstacles ``moving`` along known motions. Before ``free_until``
    (s) no obstacle of ``limits`` (m/s by name) can touch the robot, for any motion below its speed limit from time 0
    on; it is inf without such obstacles. The robot rests after the trajectory's end.
    """

    moving: tuple[str, ...]
    free: Bools
    limits: dict[str, float]
    free_until: float

    @property
    def whole(self) -> bool:
        """Whether all pieces are clear of every known motion."""
        return bool(self.free.all())

    def to_dict(self) -> dict[str, Any]:
        """Return the proof with the keys of ``trajectory.json``; empty without moving obstacles."""
        record: dict[str, Any] = {}
        if self.moving:
            record["moving"] = {"obstacles": list(self.moving), "pieces_free": int(self.free.sum())}
        if self.limits:
            until = self.free_until if np.isfinite(self.free_until) else None
            record["horizon"] = {"free_until": until, "speed_limits": self.limits}
        return record


def prove_in_time(trajectory: Trajectory, checker: CollisionChecker) -> TimeProof:
    """Prove a trajectory against the moving obstacles of the checker's scene."""
    return _prove(trajectory.coefficients, _spans(trajectory), checker)


def prove_stop_in_time(trajectory: Trajectory, t: float, stop: Trajectory, checker: CollisionChecker) -> TimeProof:
    """Prove a trajectory until ``t`` s, then its ``stop``, then rest until all known motions have ended."""
    scene = checker.world.scene
    if not scene.moving and not scene.limited:
        return _prove(stop.coefficients, _spans(stop), checker)
    count = int(np.searchsorted(trajectory.times[:-1], t))
    pieces, spans = trajectory.coefficients[:count].copy(), _spans(trajectory)[:count]
    if count:
        spans[-1, 1] = t - spans[-1, 0]
        share = spans[-1:, 1] / trajectory.seconds[count - 1]
        pieces[-1:] = part(pieces[-1:], np.zeros(1), share)
    end = t + stop.duration
    until = max((float(item.motion.end) for item in scene.moving), default=end)
    still = np.array([[end, max(until - end, NANOSECOND), 0.0]])
    later = _spans(stop) + np.array([t, 0.0, 0.0])
    stages = [pieces, stop.coefficients, stop.coefficients[-1:].sum(axis=1, keepdims=True)]
    degree = max(rows.shape[1] for rows in stages)
    stages = [np.pad(rows, ((0, 0), (0, degree - rows.shape[1]), (0, 0))) for rows in stages]
    return _prove(np.concatenate(stages), np.concatenate([spans, later, still]), checker)


def _prove(coefficients: Floats, spans: Floats, checker: CollisionChecker) -> TimeProof:
    """Prove consecutive pieces (k, degree + 1, dof); a span (k, 3) is a start and a duration."""
    scene = checker.world.scene
    free, until = np.ones(len(coefficients), dtype=bool), np.inf
    if scene.moving:
        known = TimedProver(checker, scene.moving)
        free = known.free(coefficients, spans) & known.starts(coefficients[0, 0])
    if scene.limited:
        until = _horizon(coefficients, spans, TimedProver(checker, limited=scene.limited))
    limits = {item.name: item.speed_limit for item in scene.limited}
    return TimeProof(tuple(item.name for item in scene.moving), free, limits, until)


def _spans(trajectory: Trajectory) -> Floats:
    """Return (k, 3) the start and the duration of each piece."""
    begin = trajectory.times[:-1]
    return np.column_stack([begin, trajectory.seconds, np.zeros_like(begin)])


def _horizon(coefficients: Floats, spans: Floats, prover: TimedProver) -> float:
    """Return the time (s) before which no motion of the prover's obstacles can touch the robot.

    The robot rests after the pieces' end; inf if nothing is checked.
    """
    first, last = coefficients[0, 0], coefficients[-1].sum(axis=0)
    if not prover.starts(first):
        return 0.0
    if _safe_standing_time(prover, first) < spans[0, 0]:
        return _safe_standing_time(prover, first)
    free = prover.free(coefficients, spans)
    if free.all():
        return max(float(spans[-1, :2].sum()), _safe_standing_time(prover, last))
    k = int(np.argmin(free))
    begin, duration, _ = spans[k].tolist()
    share, step = 0.0, 0.5
    for _ in range(_HALVINGS):
        low, high = np.array([share]), np.array([share + step])
        span = np.array([[begin + share * duration, step * duration, 0.0]])
        if prover.free(part(coefficients[k : k + 1], low, high), span)[0]:
            share += step
        step *= 0.5
    return begin + share * duration


def _safe_standing_time(prover: TimedProver, q: Floats) -> float:
    """Return the time (s) before which no obstacle can reach the robot at rest at ``q`` (dof,)."""
    limits = np.array([item.speed_limit for item in prover.world.obstacles])
    gaps = prover.gaps(q).reshape(prover.world.checked.shape)
    return max(0.0, float((gaps / limits).min(initial=np.inf)))


def first_touch_in_time(
    trajectory: Trajectory, checker: CollisionChecker, moving: Sequence[MovingObstacle], step: float
) -> tuple[float, Contact, Floats] | None:
    """Return time (s), contact and state of the first touch with ``moving`` that coal finds, or None.

    No point of robot or obstacles moves farther than ``step`` (m) between two samples. An interval is not sampled
    further if the distance at its middle exceeds the motion to its ends.
    """
    if not moving:
        return None
    motions = {item.name: item.motion for item in moving}
    library = CoalInTime(moving_world(checker.world, [item.standing() for item in moving]), motions)
    times, travel = _relative_motion(trajectory, checker, moving)
    last = max(1, int(np.ceil(travel[-1] / step)))
    stride, width, starts = travel[-1] / last, 1, np.zeros(1, dtype=np.int64)
    while width <= last:
        width *= _CUT
    while True:
        t = np.interp(np.minimum(starts + width // 2, last) * stride, travel, times)
        near = _are_near(library, trajectory, t, (width // 2) * stride)
        if width == 1 or not near.any():
            break
        starts = (starts[near][:, None] + np.arange(0, width, width // _CUT)).ravel()
        starts, width = starts[starts <= last], width // _CUT
    t = t[near][:1]
    touch = library.first_touch(trajectory.at(t), t) if len(t) else None
    return None if touch is None else (float(t[0]), touch[1], trajectory.at(t)[0])


def _are_near(library: CoalInTime, trajectory: Trajectory, t: Floats, extra: float) -> Bools:
    """Return at which times (n,) s something is nearer than ``extra`` (m)."""
    batches = np.split(t, range(_BATCH, len(t), _BATCH))
    return np.concatenate([library.touching(trajectory.at(some), some, extra) for some in batches])


def clearance_in_time(trajectory: Trajectory, checker: CollisionChecker, times: Floats) -> Floats:
    """Return the distance (n,) m to the nearest obstacle at ``times`` (n,) s; inf if there is none.

    Moving obstacles are at their poses of each time. See :class:`planner.collision.recheck.Clearance`.
    """
    q = trajectory.at(times)
    clearance, moving = Clearance(checker)(q), checker.world.scene.moving
    for k, t in enumerate(times if moving else ()):
        frozen = coal_checker(moving_world(checker.world, [item.standing(float(t)) for item in moving]))
        clearance[k] = min(clearance[k], Clearance(frozen)(q[k])[0])
    return clearance


def _relative_motion(
    trajectory: Trajectory, checker: CollisionChecker, moving: Sequence[MovingObstacle]
) -> tuple[Floats, Floats]:
    """Return times (k,) s, and bounds (k,) m of the relative motion of robot and obstacles up to each.

    It is linear in between.
    """
    last = trajectory.times[-1]
    changes = [item.motion.times[item.motion.times < last] for item in moving]
    times = np.unique(np.concatenate([trajectory.times, *changes]))
    middle = 0.5 * (times[1:] + times[:-1])
    piece = np.clip(np.searchsorted(trajectory.times, middle) - 1, 0, len(trajectory.seconds) - 1)
    speed = checker.world.reach.motion(trajectory.largest(1)).max(axis=1, initial=0.0)[piece]
    speed = speed + np.max([item.motion.speeds_at(middle, item.shape) for item in moving], axis=0)
    return times, cumulative_sums(speed * np.diff(times))
