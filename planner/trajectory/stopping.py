"""Braking at any moment of a trajectory, along the same curve."""

from dataclasses import dataclass, replace
from math import ceil, sqrt
from typing import Any

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

_LIMITED = KINDS[:2]  # where braking begins the acceleration jumps: no limit on the jerk can be kept
_LONGEST, _NEAREST = 4_000_000, 1_000  # ns of braking between two points
_NOISE = 1e-4  # of a limit: what the rounding of positions may take
_STILL = 1e-9  # rad/s: no motion to brake
_KEPT = 5e-4  # share of the acceleration that is kept in hand for the cubics between the points
_ROUNDING = 1e-9  # of a limit, so that what is computed from the points is within it
_SOFTER = 1.0, 0.97, 0.8, 0.5, 0.0  # of the hardest braking, where the cubic is beyond a limit with all of it
_AT_REST = 1e-9  # of ds/dt: what is left is rounding
_OFF = 1e-7  # rad (m): how far the cubics leave the curve, in their middle


@dataclass(frozen=True, eq=False)
class Stop:
    """A motion to rest: ``trajectory`` from the moment on at which braking begins, at its time 0.

    It ends where the original is at ``rest`` s. ``excess`` is by what share it exceeds a limit on velocity or
    acceleration, 0 where it keeps them all. When braking begins the acceleration jumps: jerk is not limited.
    ``trajectory.proven`` says whether all else is proven of its own pieces; that takes a checker.
    """

    trajectory: Trajectory
    rest: float
    excess: float

    @property
    def proven(self) -> bool:
        """Within limits on velocity and acceleration, and every piece free; False where no checker was given."""
        return self.trajectory.proven

    def text(self) -> str:
        """What is known of the stop, in one sentence."""
        kept = "within limits" if self.excess == 0.0 else f"{100 * self.excess:.2g} % over a limit"
        proof = "not proven: give stop_at the checker" if not self.trajectory.proof else "not proven"
        return f"at rest after {self.trajectory.duration:.3f} s, {kept}, {'proven free' if self.proven else proof}"


def stop_at(
    trajectory: Trajectory, t: float, checker: CollisionChecker | None = None, limits: MotionLimits | None = None
) -> Stop:
    """Brake from ``t`` s on as hard as ``limits`` allow, the trajectory's own by default, along its curve.

    With c = ds/dt of the trajectory's own time s the joints' acceleration is q' dc/dt + q'' c²: from point to point c
    falls evenly, by as much as keeps the cubic between the points within the limits. That it does not fall does so
    always, as the trajectory keeps them itself (:func:`~planner.trajectory.timing.time_path` leaves room for the
    cubics), so that at worst the motion ends where the trajectory does. The cubics stay within 1e-7 rad of the
    curve. With a ``checker`` they are proven; without one ``proven`` is False. Raises :class:`LimitError` where neither
    the call nor the trajectory has limits.
    """
    limits = limits or trajectory.limits
    if limits is None:
        raise LimitError("the trajectory has no limits to brake within: give stop_at the limits.")
    if checker is not None:
        require_joints(trajectory.joints, checker)
    t = float(np.clip(numbers("t", t, ()), trajectory.times[0], trajectory.times[-1]))
    braking = _Braking(trajectory, limits)
    if np.abs(trajectory.at(t, 1)).max() < _STILL or t == trajectory.times[-1]:
        q = np.repeat(trajectory.at(t), 2, axis=0)
        made, rest = Trajectory(trajectory.joints, np.array([0, braking.apart]), (q, 0.0 * q), "stop"), t
    else:
        made, rest = braking.from_moment(t)
    share = max(made.worst(order, getattr(limits, kind), 1.0)[0] for order, kind in enumerate(_LIMITED, 1))
    made = replace(made, limits=limits)
    if checker is not None:
        proven, proof = _proof(trajectory, t, made, limits, checker)
        made = replace(made, proven=proven, proof=proof)
    return Stop(made, rest, max(0.0, share - 1.0))


def _proof(
    trajectory: Trajectory, t: float, made: Trajectory, limits: MotionLimits, checker: CollisionChecker
) -> tuple[bool, dict[str, Any]]:
    """Of the stop's own pieces; among what moves, of the trajectory until ``t``, and of standing from then on, too."""
    in_time = prove_stop_in_time(trajectory, t, made, checker)
    proof = prove_motion(made, EdgeProver(checker), limits, kinds=_LIMITED, in_time=in_time)
    return proof.whole, proof.to_dict(checker.world.margin, checker.name)


@dataclass(frozen=True, eq=False)
class _Place:
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
        self.apart = min_knot_interval(limits, trajectory.knots(), _LIMITED, _NEAREST, _NOISE)

    def from_moment(self, t: float) -> tuple[Trajectory, float]:
        """The motion to rest, and where on the trajectory that is."""
        places, clock, duration = [self._place(t, 1.0)], [0], _LONGEST
        while places[-1].c > 0.0 and places[-1].s < self._trajectory.times[-1]:
            place, duration = self._step(places[-1], min(2 * duration, _LONGEST))
            places.append(place)
            clock.append(clock[-1] + duration)
        q, qd = np.array([place.q for place in places]), np.array([place.c * place.slope for place in places])
        qd[-1] = 0.0
        return Trajectory(self._trajectory.joints, np.array(clock), (q, qd), "stop"), places[-1].s

    def _step(self, place: _Place, duration: int) -> tuple[_Place, int]:
        """The next point and the nanoseconds until then, ``duration`` at most."""
        best, least = None, np.inf
        while True:
            hardest = self._hardest(place, duration)
            for share in _SOFTER:
                following, takes = self._after(place, share * hardest, duration)
                over, off = self._misses(place, following, takes)
                if over <= 0.0 and off <= _OFF:
                    return following, takes
                if duration <= self.apart and over < least:
                    best, least = (following, takes), over
            if best is not None:
                return best
            duration = max(duration // 2, self.apart)

    def _hardest(self, place: _Place, duration: int) -> float:
        """The least dc/dt, 0 at most, that keeps to the accelerations at both ends of a step of ``duration`` ns."""
        found = min(0.0, _least(place, self._most))
        following, _ = self._after(place, found, duration)
        return min(0.0, max(found, _least(following, self._most)))

    def _after(self, place: _Place, change: float, duration: int) -> tuple[_Place, int]:
        """Where braking at ``change`` (dc/dt) leads in ``duration`` ns, or until rest, or the trajectory's next knot.

        There its jerk jumps: a cubic across it would be beyond what the trajectory itself keeps to.
        """
        if place.c + change * duration * NANOSECOND <= 0.0:
            duration = max(ceil(-place.c / change / NANOSECOND), self.apart)
            change = -place.c / (duration * NANOSECOND)
        knot = float(self._trajectory.times[self._piece(place.s + 0.5 * NANOSECOND) + 1])
        reached = place.c**2 + 2.0 * change * (knot - place.s)
        if reached >= 0.0:
            until = 2.0 * (knot - place.s) / (place.c + sqrt(reached)) / NANOSECOND
            if until < duration + self.apart:
                duration = max(round(until if until <= duration else 0.5 * until), self.apart)
        seconds = duration * NANOSECOND
        c = place.c + change * seconds
        c = c if c > _AT_REST else 0.0
        s, end = place.s + 0.5 * (place.c + c) * seconds, float(self._trajectory.times[-1])
        return self._place(s if s + NANOSECOND < end else end, c), duration

    def _piece(self, s: float) -> int:
        times = self._trajectory.times
        return min(max(int(np.searchsorted(times, s, side="right")) - 1, 0), len(times) - 2)

    def _place(self, s: float, c: float) -> _Place:
        piece = self._piece(s)
        h = float(self._trajectory.seconds[piece])
        u = (s - float(self._trajectory.times[piece])) / h
        return _Place(s, c, *(_horner(rows[piece], u) / h**order for order, rows in enumerate(self._derivatives)))

    def _misses(self, place: _Place, following: _Place, duration: int) -> tuple[float, float]:
        """By what share the cubic between two points is beyond a limit, and how far its middle is off the curve.

        Where the trajectory is itself beyond a limit, it is that which counts.
        """
        seconds = duration * NANOSECOND
        first, last = place.c * place.slope, following.c * following.slope
        mean = (following.q - place.q) / seconds
        ends = np.abs([6.0 * mean - 4.0 * first - 2.0 * last, 2.0 * first + 4.0 * last - 6.0 * mean]) / seconds
        most = _raised(self._most, place.bend * place.c**2, following.bend * following.c**2)
        share = max(
            (ends / most).max(), (np.abs(3.0 * mean - first - last) / _raised(self._fastest, first, last)).max()
        )
        halfway = self._place(place.s + 0.125 * (3.0 * place.c + following.c) * seconds, 0.0)
        middle = 0.5 * (place.q + following.q) + 0.125 * seconds * (first - last)
        return float(share) - 1.0, float(np.abs(middle - halfway.q).max())


def _horner(coefficients: Floats, u: float) -> Floats:
    value = coefficients[-1]
    for row in coefficients[-2::-1]:
        value = value * u + row
    return value


def _raised(limit: Floats, first: Floats, last: Floats) -> Floats:
    """Limits (dof,), or what is beyond them already at one of two places."""
    own = np.maximum(np.abs(first), np.abs(last))
    return np.where(own > limit, (1.0 + _KEPT) * own, limit)


def _least(place: _Place, most: Floats) -> float:
    """The least dc/dt that keeps accelerations within ``most`` (dof,) at a place."""
    curved, slope = place.bend * place.c**2, np.abs(place.slope)
    allowed = np.maximum((1.0 - _KEPT) * most, np.abs(curved)) + np.sign(place.slope) * curved
    return float(np.max(-allowed / np.where(slope > 0.0, slope, 1.0), where=slope > 0.0, initial=-np.inf))
