"""Stops: braking at any moment of a trajectory along its own curve."""

from dataclasses import dataclass, replace
from math import ceil, sqrt

import numpy as np

from planner.base.arrays import Floats, numbers
from planner.base.polynomials import derivative
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.trajectory.curve import min_knot_interval
from planner.trajectory.limits import KINDS, LimitError, MotionLimits
from planner.trajectory.moving_obstacles import prove_stop_in_time
from planner.trajectory.proof import prove_motion, require_joints
from planner.trajectory.trajectory import NANOSECOND, Trajectory

_LIMITED = KINDS[:2]  # the acceleration jumps at the start of braking, so no jerk limit can hold
_LONGEST, _NEAREST = 4_000_000, 1_000  # ns of braking between two points
_NOISE = 1e-4  # of a limit: the share that rounded positions may use
_STILL = 1e-9  # rad/s: below it the robot is at rest
_RESERVE = 5e-4  # share of the acceleration for the cubics between the points
_ROUNDING = 1e-9  # of a limit: the rounding error of quantities that are computed from the points
_SOFTER = 1.0, 0.97, 0.8, 0.5, 0.0  # shares of the hardest braking, tried until the cubic is within limits
_AT_REST = 1e-9  # of ds/dt: the rest is rounding error
_OFF = 1e-7  # rad (m): largest distance of a cubic's middle from the curve


@dataclass(frozen=True, eq=False)
class Stop:
    """A motion to rest: ``trajectory`` starts at its time 0, when braking starts.

    It ends where the original is at ``rest`` s. ``excess`` is the share by which it exceeds a limit on velocity or
    acceleration, 0 if it keeps them all. The acceleration jumps at the start of braking, so jerk is not limited.
    ``trajectory.proven`` is about the stop's own pieces, and needs a checker.
    """

    trajectory: Trajectory
    rest: float
    excess: float

    @property
    def proven(self) -> bool:
        """Whether limits hold and every piece is free; False without a checker."""
        return self.trajectory.proven

    def text(self) -> str:
        """Return the stop in one sentence."""
        limits = "within limits" if self.excess == 0.0 else f"{100 * self.excess:.2g} % over a limit"
        proof = "not proven" if self.trajectory.proof else "not proven: give stop_at the checker"
        return f"at rest after {self.trajectory.duration:.3f} s, {limits}, {'proven free' if self.proven else proof}"


def stop_at(
    trajectory: Trajectory, t: float, checker: CollisionChecker | None = None, limits: MotionLimits | None = None
) -> Stop:
    """Brake from ``t`` s on along the curve, as hard as ``limits`` (by default the trajectory's) allow.

    With c = ds/dt of the trajectory's own time s the joint acceleration is q' dc/dt + q'' c². From point to point c
    falls linearly, as fast as the cubic between the points keeps the limits. A constant c always keeps them, because
    the trajectory does (:func:`~planner.trajectory.timing.time_path` leaves a reserve for the cubics), so the motion
    ends with the trajectory at the latest. The cubics stay within 1e-7 rad of the curve. With a ``checker`` they are
    proven; without one ``proven`` is False. Raises :class:`LimitError` if neither the call nor the trajectory has
    limits.
    """
    limits = limits or trajectory.limits
    if limits is None:
        raise LimitError("limits must come from the call or the trajectory, got none: give stop_at limits.")
    if checker is not None:
        require_joints(trajectory.joints, checker)
    t = float(np.clip(numbers("t", t, ()), trajectory.times[0], trajectory.times[-1]))
    braking = _Braking(trajectory, limits)
    if np.abs(trajectory.at(t, 1)).max() < _STILL or t == trajectory.times[-1]:
        q = np.repeat(trajectory.at(t), 2, axis=0)
        stop, rest = Trajectory(trajectory.joints, np.array([0, braking.knot_interval]), (q, 0.0 * q), "stop"), t
    else:
        stop, rest = braking.brake_from(t)
    share = max(stop.worst(order, getattr(limits, kind), 1.0)[0] for order, kind in enumerate(_LIMITED, 1))
    stop = replace(stop, limits=limits)
    if checker is not None:
        in_time = prove_stop_in_time(trajectory, t, stop, checker)
        proof = prove_motion(stop, EdgeProver(checker), limits, kinds=_LIMITED, in_time=in_time)
        stop = replace(stop, proven=proof.whole, proof=proof.to_dict(checker.world.margin, checker.name))
    return Stop(stop, rest, max(0.0, share - 1.0))


@dataclass(frozen=True, eq=False)
class _Point:
    """A moment s of the trajectory: position and its first two derivatives there (dof,), and c = ds/dt."""

    s: float
    c: float
    q: Floats
    slope: Floats
    bend: Floats


class _Braking:
    """The steps of a stop along a trajectory within limits (dof,) on velocities and accelerations."""

    def __init__(self, trajectory: Trajectory, limits: MotionLimits) -> None:
        self._trajectory = trajectory
        self._fastest = (1.0 - _ROUNDING) * limits.velocity
        self._most = (1.0 - _ROUNDING) * limits.acceleration
        self._derivatives = [derivative(trajectory.coefficients, order) for order in range(3)]
        self.knot_interval = min_knot_interval(limits, trajectory.knots(), _LIMITED, _NEAREST, _NOISE)

    def brake_from(self, t: float) -> tuple[Trajectory, float]:
        """Return the motion to rest, and its end on the trajectory (s)."""
        points, clock, duration = [self._point_at(t, 1.0)], [0], _LONGEST
        while points[-1].c > 0.0 and points[-1].s < self._trajectory.times[-1]:
            point, duration = self._step(points[-1], min(2 * duration, _LONGEST))
            points.append(point)
            clock.append(clock[-1] + duration)
        q, qd = np.array([point.q for point in points]), np.array([point.c * point.slope for point in points])
        qd[-1] = 0.0
        return Trajectory(self._trajectory.joints, np.array(clock), (q, qd), "stop"), points[-1].s

    def _step(self, point: _Point, duration: int) -> tuple[_Point, int]:
        """Return the next point, and the nanoseconds until then, ``duration`` at most."""
        best, least = None, np.inf
        while True:
            hardest = self._find_hardest(point, duration)
            for share in _SOFTER:
                following, takes = self._advance(point, share * hardest, duration)
                over, off = self._measure_cubic(point, following, takes)
                if over <= 0.0 and off <= _OFF:
                    return following, takes
                if duration <= self.knot_interval and over < least:
                    best, least = (following, takes), over
            if best is not None:
                return best
            duration = max(duration // 2, self.knot_interval)

    def _find_hardest(self, point: _Point, duration: int) -> float:
        """Return the least dc/dt <= 0 that keeps the acceleration limits at both ends of a step."""
        change = min(0.0, _least_change(point, self._most))
        following, _ = self._advance(point, change, duration)
        return min(0.0, max(change, _least_change(following, self._most)))

    def _advance(self, point: _Point, change: float, duration: int) -> tuple[_Point, int]:
        """Return the point after braking at ``change`` (dc/dt) for ``duration`` ns, and the nanoseconds used.

        The step ends early at rest, and at the trajectory's next knot: its jerk jumps there, and a cubic across it
        would exceed the trajectory's own values.
        """
        if point.c + change * duration * NANOSECOND <= 0.0:
            duration = max(ceil(-point.c / change / NANOSECOND), self.knot_interval)
            change = -point.c / (duration * NANOSECOND)
        knot = float(self._trajectory.times[self._piece(point.s + 0.5 * NANOSECOND) + 1])
        reached = point.c**2 + 2.0 * change * (knot - point.s)
        if reached >= 0.0:
            until = 2.0 * (knot - point.s) / (point.c + sqrt(reached)) / NANOSECOND
            if until < duration + self.knot_interval:
                duration = max(round(until if until <= duration else 0.5 * until), self.knot_interval)
        seconds = duration * NANOSECOND
        c = point.c + change * seconds
        c = c if c > _AT_REST else 0.0
        s, end = point.s + 0.5 * (point.c + c) * seconds, float(self._trajectory.times[-1])
        return self._point_at(s if s + NANOSECOND < end else end, c), duration

    def _piece(self, s: float) -> int:
        times = self._trajectory.times
        return min(max(int(np.searchsorted(times, s, side="right")) - 1, 0), len(times) - 2)

    def _point_at(self, s: float, c: float) -> _Point:
        piece = self._piece(s)
        h = float(self._trajectory.seconds[piece])
        u = (s - float(self._trajectory.times[piece])) / h
        return _Point(s, c, *(_horner(rows[piece], u) / h**order for order, rows in enumerate(self._derivatives)))

    def _measure_cubic(self, point: _Point, following: _Point, duration: int) -> tuple[float, float]:
        """Return the cubic's excess over a limit as a share, and the distance of its middle from the curve.

        If the trajectory itself exceeds a limit, its value replaces the limit.
        """
        seconds = duration * NANOSECOND
        first, last = point.c * point.slope, following.c * following.slope
        mean = (following.q - point.q) / seconds
        ends = np.abs([6.0 * mean - 4.0 * first - 2.0 * last, 2.0 * first + 4.0 * last - 6.0 * mean]) / seconds
        most = _relax(self._most, point.bend * point.c**2, following.bend * following.c**2)
        share = max((ends / most).max(), (np.abs(3.0 * mean - first - last) / _relax(self._fastest, first, last)).max())
        halfway = self._point_at(point.s + 0.125 * (3.0 * point.c + following.c) * seconds, 0.0)
        middle = 0.5 * (point.q + following.q) + 0.125 * seconds * (first - last)
        return float(share) - 1.0, float(np.abs(middle - halfway.q).max())


def _horner(coefficients: Floats, u: float) -> Floats:
    value = coefficients[-1]
    for row in coefficients[-2::-1]:
        value = value * u + row
    return value


def _relax(limit: Floats, first: Floats, last: Floats) -> Floats:
    """Return limits (dof,), raised to values that exceed them at one of two points."""
    own = np.maximum(np.abs(first), np.abs(last))
    return np.where(own > limit, (1.0 + _RESERVE) * own, limit)


def _least_change(point: _Point, most: Floats) -> float:
    """Return the least dc/dt that keeps accelerations within ``most`` (dof,) at a point."""
    curved, slope = point.bend * point.c**2, np.abs(point.slope)
    allowed = np.maximum((1.0 - _RESERVE) * most, np.abs(curved)) + np.sign(point.slope) * curved
    return float(np.max(-allowed / np.where(slope > 0.0, slope, 1.0), where=slope > 0.0, initial=-np.inf))
