"""What is proven of a trajectory among obstacles that move: clear of known motions, and a horizon for unknown ones."""

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
_CUT = 7  # parts of a stretch that is looked at more closely
_BATCH = 2048  # moments that are asked for at once


@dataclass(frozen=True, eq=False)
class TimeProof:
    """What is proven of a trajectory in time; the scene's times are those of the trajectory.

    ``free`` (k,): pieces proven clear of the obstacles ``moving`` along known motions. ``free_until`` (s): until then
    nothing can touch of ``limits`` (m/s by name), whatever these obstacles do below their speed limits from time 0 on;
    beyond the trajectory's end the robot stands. inf where there are none.
    """

    moving: tuple[str, ...]
    free: Bools
    limits: dict[str, float]
    free_until: float

    @property
    def whole(self) -> bool:
        """All pieces are clear of every known motion."""
        return bool(self.free.all())

    def to_dict(self) -> dict[str, Any]:
        """What ``trajectory.json`` has of it; nothing where nothing moves."""
        found: dict[str, Any] = {}
        if self.moving:
            found["moving"] = {"obstacles": list(self.moving), "pieces_free": int(self.free.sum())}
        if self.limits:
            until = self.free_until if np.isfinite(self.free_until) else None
            found["horizon"] = {"free_until": until, "speed_limits": self.limits}
        return found


def prove_in_time(trajectory: Trajectory, checker: CollisionChecker) -> TimeProof:
    """The proofs of a trajectory against what moves in the checker's scene."""
    return _prove(trajectory.coefficients, _spans(trajectory), checker)


def prove_stop_in_time(trajectory: Trajectory, t: float, stop: Trajectory, checker: CollisionChecker) -> TimeProof:
    """Of a trajectory until ``t`` s, its ``stop`` from there on, and standing until all known motions have ended."""
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
    made = [pieces, stop.coefficients, stop.coefficients[-1:].sum(axis=1, keepdims=True)]
    degree = max(rows.shape[1] for rows in made)
    made = [np.pad(rows, ((0, 0), (0, degree - rows.shape[1]), (0, 0))) for rows in made]
    return _prove(np.concatenate(made), np.concatenate([spans, later, still]), checker)


def _prove(coefficients: Floats, spans: Floats, checker: CollisionChecker) -> TimeProof:
    """Of pieces (k, degree + 1, dof) one after the other, each begun and taking as long as its span (k, 3) says."""
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
    """(k, 3) when each piece begins and how long it takes."""
    begin = trajectory.times[:-1]
    return np.column_stack([begin, trajectory.seconds, np.zeros_like(begin)])


def _horizon(coefficients: Floats, spans: Floats, prover: TimedProver) -> float:
    """Until when (s) every moment from time 0 on is proven free, whatever the prover's obstacles do below their limits.

    Beyond the pieces' end the robot stands; inf where nothing is checked.
    """
    first, last = coefficients[0, 0], coefficients[-1].sum(axis=0)
    if not prover.starts(first):
        return 0.0
    if _standing_until(prover, first) < spans[0, 0]:
        return _standing_until(prover, first)
    free = prover.free(coefficients, spans)
    if free.all():
        return max(float(spans[-1, :2].sum()), _standing_until(prover, last))
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


def _standing_until(prover: TimedProver, q: Floats) -> float:
    """Until when (s) nothing can reach the robot where it stands (dof,)."""
    limits = np.array([item.speed_limit for item in prover.world.obstacles])
    gaps = prover.gaps(q).reshape(prover.world.checked.shape)
    return max(0.0, float((gaps / limits).min(initial=np.inf)))


def first_touch_in_time(
    trajectory: Trajectory, checker: CollisionChecker, moving: Sequence[MovingObstacle], step: float
) -> tuple[float, Contact, Floats] | None:
    """When (s), with what and in which configuration coal first sees one of ``moving`` touch the robot; else None.

    No point of the robot or of an obstacle moves farther than ``step`` (m) between two looks. Where they are farther
    apart, by coal's own word, than they move from there to the ends of a stretch, no more is looked at on it.
    """
    if not moving:
        return None
    motions = {item.name: item.motion for item in moving}
    judge = CoalInTime(moving_world(checker.world, [item.standing() for item in moving]), motions)
    times, moved = _moved(trajectory, checker, moving)
    last = max(1, int(np.ceil(moved[-1] / step)))
    stride, width, starts = moved[-1] / last, 1, np.zeros(1, dtype=np.int64)
    while width <= last:
        width *= _CUT
    while True:
        t = np.interp(np.minimum(starts + width // 2, last) * stride, moved, times)
        near = _touching(judge, trajectory, t, (width // 2) * stride)
        if width == 1 or not near.any():
            break
        starts = (starts[near][:, None] + np.arange(0, width, width // _CUT)).ravel()
        starts, width = starts[starts <= last], width // _CUT
    t = t[near][:1]
    found = judge.first_touch(trajectory.at(t), t) if len(t) else None
    return None if found is None else (float(t[0]), found[1], trajectory.at(t)[0])


def _touching(judge: CoalInTime, trajectory: Trajectory, t: Floats, extra: float) -> Bools:
    """At which of many times (n,) s something is nearer than ``extra`` (m)."""
    batches = np.split(t, range(_BATCH, len(t), _BATCH))
    return np.concatenate([judge.touching(trajectory.at(some), some, extra) for some in batches])


def clearance_in_time(trajectory: Trajectory, checker: CollisionChecker, times: Floats) -> Floats:
    """Distance (n,) m of the nearest thing at ``times`` (n,) s, with what moves where it is then; inf for nothing.

    See :class:`planner.collision.recheck.Clearance`.
    """
    q = trajectory.at(times)
    found, moving = Clearance(checker)(q), checker.world.scene.moving
    for k, t in enumerate(times if moving else ()):
        among = coal_checker(moving_world(checker.world, [item.standing(float(t)) for item in moving]))
        found[k] = min(found[k], Clearance(among)(q[k])[0])
    return found


def _moved(
    trajectory: Trajectory, checker: CollisionChecker, moving: Sequence[MovingObstacle]
) -> tuple[Floats, Floats]:
    """Times (k,) s of a trajectory, and by how much (m) the robot and any obstacle have moved apart at most till then.

    Between two of the times that grows evenly.
    """
    last = trajectory.times[-1]
    changes = [item.motion.times[item.motion.times < last] for item in moving]
    times = np.unique(np.concatenate([trajectory.times, *changes]))
    middle = 0.5 * (times[1:] + times[:-1])
    piece = np.clip(np.searchsorted(trajectory.times, middle) - 1, 0, len(trajectory.seconds) - 1)
    speed = checker.world.reach.motion(trajectory.largest(1)).max(axis=1, initial=0.0)[piece]
    speed = speed + np.max([item.motion.speeds_at(middle, item.shape) for item in moving], axis=0)
    return times, cumulative_sums(speed * np.diff(times))
