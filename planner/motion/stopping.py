"""Braking at any moment of a trajectory, along the same curve."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.base.polynomials import derivative
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.motion.in_time import prove_stop_in_time
from planner.motion.limits import KINDS, MotionLimits
from planner.motion.proof import prove_motion
from planner.motion.smoothing import apart_for
from planner.motion.trajectory import NANOSECOND, Trajectory

_LIMITED = KINDS[:2]  # where braking begins the acceleration jumps: no limit on the jerk can be kept
_LONGEST = 4_000_000  # ns of braking between two points
_STILL = 1e-9  # rad/s: no motion to brake
_KEPT = 5e-4  # share of the acceleration that is kept in hand for the cubics between the points
_ROUNDING = 1e-9  # of a limit, so that what is computed from the points is within it
_SOFTER = 1.0, 0.97, 0.8, 0.5  # of the hardest braking, where the cubic is beyond a limit with all of it
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


def stop_at(trajectory: Trajectory, t: float, limits: MotionLimits, checker: CollisionChecker | None = None) -> Stop:
    """Brake from ``t`` s on as hard as ``limits`` allow while following the curve of ``trajectory``.

    With c = ds/dt of the trajectory's own time s the joints' acceleration is q' dc/dt + q'' c²: from point to point c
    falls evenly, by as much as keeps the cubic between the points within the limits. That it does not fall does so
    always, as the trajectory keeps them itself (:func:`planner.motion.timing.time_path` leaves room for the cubics), so
    that at worst the motion ends where the trajectory does. The cubics stay within 1e-7 rad of the curve. With a
    ``checker`` they are proven; without one ``proven`` is False.
    """
    t = float(np.clip(t, trajectory.times[0], trajectory.times[-1]))
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
        self.apart = apart_for(limits, trajectory.knots(), orders=len(_LIMITED))

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
        while True:
            hardest = self._hardest(place, duration)
            for share in _SOFTER:
                following, takes = self._after(place, share * hardest, duration)
                if self._keeps(place, following, takes):
                    return following, takes
            if duration <= self.apart:
                return self._after(place, 0.0, duration)
            duration = max(duration // 2, self.apart)

    def _hardest(self, place: _Place, duration: int) -> float:
        """The least dc/dt, 0 at most, that keeps to the accelerations at both ends of a step of ``duration`` ns."""
        found = min(0.0, _least(place, place.c, self._most))
        following, _ = self._after(place, found, duration)
        return min(0.0, max(found, _least(following, following.c, self._most)))

    def _after(self, place: _Place, change: float, duration: int) -> tuple[_Place, int]:
        """Where braking at ``change`` (dc/dt) leads in ``duration`` ns, or until rest, or until the trajectory ends."""
        if place.c + change * duration * NANOSECOND <= 0.0:
            duration = max(ceil(-place.c / change / NANOSECOND), self.apart)
            change = -place.c / (duration * NANOSECOND)
        seconds = duration * NANOSECOND
        c = max(0.0, place.c + change * seconds) if change != -place.c / seconds else 0.0
        s, end = place.s + 0.5 * (place.c + c) * seconds, float(self._trajectory.times[-1])
        if s < end:
            return self._place(s, c), duration
        duration = max(ceil(2.0 * (end - place.s) / (place.c + c) / NANOSECOND), self.apart)
        return self._place(end, c), duration

    def _place(self, s: float, c: float) -> _Place:
        times, seconds = self._trajectory.times, self._trajectory.seconds
        piece = min(max(int(np.searchsorted(times, s, side="right")) - 1, 0), len(seconds) - 1)
        h = float(seconds[piece])
        u = (s - float(times[piece])) / h
        return _Place(s, c, *(_horner(rows[piece], u) / h**order for order, rows in enumerate(self._derivatives)))

    def _keeps(self, place: _Place, following: _Place, duration: int) -> bool:
        """Whether the cubic between two points keeps to the limits, and to the curve in its middle."""
        seconds = duration * NANOSECOND
        first, last = place.c * place.slope, following.c * following.slope
        mean = (following.q - place.q) / seconds
        ends = np.abs([6.0 * mean - 4.0 * first - 2.0 * last, 2.0 * first + 4.0 * last - 6.0 * mean]) / seconds
        if not ((ends <= self._most).all() and (np.abs(3.0 * mean - first - last) <= self._fastest).all()):
            return False
        halfway = self._place(place.s + 0.125 * (3.0 * place.c + following.c) * seconds, 0.0)
        middle = 0.5 * (place.q + following.q) + 0.125 * seconds * (first - last)
        return bool(np.abs(middle - halfway.q).max() <= _OFF)


def _horner(coefficients: Floats, u: float) -> Floats:
    value = coefficients[-1]
    for row in coefficients[-2::-1]:
        value = value * u + row
    return value


def _least(place: _Place, c: float, most: Floats) -> float:
    """The least dc/dt that keeps accelerations within ``most`` (dof,) at a place passed at c."""
    curved, slope = place.bend * c**2, np.abs(place.slope)
    allowed = np.maximum((1.0 - _KEPT) * most, np.abs(curved)) + np.sign(place.slope) * curved
    return float(np.max(-allowed / np.where(slope > 0.0, slope, 1.0), where=slope > 0.0, initial=-np.inf))
