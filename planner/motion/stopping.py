"""Braking at any moment of a trajectory, along the same curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, numbers
from planner.base.polynomials import derivative
from planner.motion.limits import MotionLimits
from planner.motion.trajectory import Trajectory

_LONGEST = 4e-3  # s of the trajectory between two changes of the braking
_SHORTEST = 1e-5  # s: the noise of cubics between nearer knots grows with 1 / h²
_STILL = 1e-9  # rad/s: no motion to brake
_AT_REST = 1e-6  # of x: what is left is braked away on the same step
_KEPT = 5e-4  # share of the acceleration that is kept in hand for the cubics between the knots


@dataclass(frozen=True, eq=False)
class Stop:
    """A motion to rest: ``trajectory`` from the moment on at which braking begins, at its time 0.

    It ends where the original is at ``rest`` s. ``excess`` is by what share it exceeds a limit on velocity or
    acceleration, 0 where it keeps them all. When braking begins the acceleration jumps: jerk is not limited.
    """

    trajectory: Trajectory
    rest: float
    excess: float


def stop_at(trajectory: Trajectory, t: float, limits: MotionLimits) -> Stop:
    """Brake from ``t`` s on as hard as ``limits`` allow while following the curve of ``trajectory``.

    With c = ds/dt of the trajectory's own time s and x = c², the joints' acceleration is q' u + q'' x, dx/ds = 2 u: on
    each interval the least u that keeps to the limits at both ends. u = 0 always does, as the trajectory keeps them
    itself, so that at worst the motion ends where the trajectory does. Intervals are halved until the cubics between
    their ends keep to the limits as well; :func:`planner.motion.timing.time_path` leaves room for these.
    """
    t = float(np.clip(numbers("t", t, ()), trajectory.times[0], trajectory.times[-1]))
    if np.abs(trajectory.at(t, 1)).max() < _STILL or trajectory.times[-1] - t < _SHORTEST:
        q = np.repeat(trajectory.at(t), 2, axis=0)
        still = Trajectory.through(trajectory.joints, np.array([0.0, _SHORTEST]), q, 0.0 * q, law="stop")
        return Stop(still, t, 0.0)
    braking, x, reached, clock = _Braking(trajectory, limits.acceleration), [1.0], [t], [0.0]
    while x[-1] > 0.0 and reached[-1] < trajectory.times[-1]:
        s, after, seconds = braking.step(reached[-1], x[-1])
        reached.append(s)
        x.append(after)
        clock.append(clock[-1] + seconds)
    s, speed = np.array(reached), np.sqrt(x)[:, None]
    q, qd = trajectory.at(s), speed * trajectory.at(s, 1)
    qd[-1] = 0.0
    made = Trajectory.through(trajectory.joints, np.array(clock), q, qd, law="stop")
    share = max(made.worst(1, limits.velocity, 1.0)[0], made.worst(2, limits.acceleration, 1.0)[0])
    return Stop(made, reached[-1], max(0.0, share - 1.0))


class _Braking:
    """The steps of a stop along a trajectory within limits (dof,) on accelerations."""

    def __init__(self, trajectory: Trajectory, most: Floats) -> None:
        self._trajectory, self._most = trajectory, most
        self._derivatives = [derivative(trajectory.coefficients, order) for order in range(3)]

    def step(self, s: float, x: float) -> tuple[float, float, float]:
        """The next moment of the trajectory, x there, and the seconds until then."""
        times = self._trajectory.times
        piece = int(self._trajectory.piece_at(np.array([s + 0.5 * _SHORTEST]))[0])
        step = min(times[piece + 1] - s, _LONGEST)
        if times[piece + 1] - s - step < _SHORTEST:
            step = times[piece + 1] - s
        while True:
            states = self._states(piece, s, step)
            u = _least(states[1], states[2], x, step, self._most)
            end = x + 2.0 * step * u
            if end < _AT_REST:
                rest = -0.5 * x / u if u < 0.0 else step
                step, end = float(np.clip(rest, min(step, _SHORTEST), step)), 0.0
                states = self._states(piece, s, step)
            seconds = 2.0 * step / (np.sqrt(x) + np.sqrt(end))
            if step < 2.0 * _SHORTEST or _keeps(states, np.sqrt([x, end]), seconds, self._most):
                return min(s + step, float(times[-1])), end, seconds
            step *= 0.5

    def _states(self, piece: int, s: float, step: float) -> list[Floats]:
        """Positions (2, dof) at both ends of an interval, first and second derivatives."""
        h = float(np.diff(self._trajectory.times[piece : piece + 2])[0])
        u = (np.array([[s], [s + step]]) - self._trajectory.times[piece]) / h
        return [_horner(rows[piece], u) / h**order for order, rows in enumerate(self._derivatives)]


def _horner(coefficients: Floats, u: Floats) -> Floats:
    value = np.broadcast_to(coefficients[-1], (len(u), coefficients.shape[1]))
    for row in coefficients[-2::-1]:
        value = value * u + row
    return value


def _least(slope: Floats, bend: Floats, x: float, step: float, most: Floats) -> float:
    """The least u, 0 at most, that keeps accelerations within ``most`` (dof,) at both ends of an interval."""
    allowed = np.maximum((1.0 - _KEPT) * most, np.abs(bend) * x)
    by_u = np.stack([slope[0], slope[1] + 2.0 * step * bend[1]])
    with np.errstate(divide="ignore", invalid="ignore"):
        low = np.where(by_u > 0, (-allowed - bend * x) / by_u, np.where(by_u < 0, (allowed - bend * x) / by_u, -np.inf))
    return min(0.0, float(low.max()))


def _keeps(states: list[Floats], speed: Floats, seconds: float, most: Floats) -> bool:
    """Whether the cubic between two states, passed at ``speed`` (2,), keeps accelerations within ``most`` (dof,)."""
    delta, v = (states[0][1] - states[0][0]) / seconds, speed[:, None] * states[1]
    ends = np.abs([6.0 * delta - 4.0 * v[0] - 2.0 * v[1], 2.0 * v[0] + 4.0 * v[1] - 6.0 * delta]) / seconds
    return bool((ends <= most).all())
