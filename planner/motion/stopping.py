"""Braking at any moment of a trajectory, along the same curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.motion.limits import MotionLimits
from planner.motion.trajectory import Trajectory

_STEP = 2e-3  # s of the trajectory between two changes of the braking, at most
_KEPT = 1e-3  # share of the acceleration that is kept in hand for the cubics between the knots


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
    itself, so that at worst the motion ends where the trajectory does.
    """
    t = float(np.clip(t, trajectory.times[0], trajectory.times[-1]))
    s = _grid(trajectory, t)
    slope, bend = trajectory.at(s, 1), trajectory.at(s, 2)
    x, c = [1.0], [0.0]
    for k, step in enumerate(np.diff(s).tolist()):
        if x[-1] == 0.0:
            break
        u = _least(slope[k : k + 2], bend[k : k + 2], x[-1], step, limits.acceleration)
        x.append(max(0.0, x[-1] + 2.0 * step * u))
        c.append(c[-1] + 2.0 * step / (np.sqrt(x[-2]) + np.sqrt(x[-1])))
    n = len(x)
    speed = np.sqrt(x)
    speed[-1] = 0.0
    made = _through(trajectory, np.array(c), s[:n], slope[:n] * speed[:, None])
    shares = [(made.largest(1) / limits.velocity).max(), (made.largest(2) / limits.acceleration).max()]
    return Stop(made, float(s[n - 1]), max(0.0, float(max(shares)) - 1.0))


def _grid(trajectory: Trajectory, t: float) -> Floats:
    """Moments (n,) from ``t`` to the end: the knots, and others so that none is more than ``_STEP`` after the last."""
    count = max(1, int(np.ceil((trajectory.times[-1] - t) / _STEP)))
    even = np.linspace(t, trajectory.times[-1], count + 1)
    s = np.union1d(trajectory.times[trajectory.times > t], even)
    kept = s[np.concatenate([[True], np.diff(s) > 0.1 * _STEP])]
    return np.concatenate([kept[:-1], s[-1:]]) if len(kept) > 1 else np.array([t, max(s[-1], t + _STEP)])


def _least(slope: Floats, bend: Floats, x: float, step: float, most: Floats) -> float:
    """The least u, 0 at most, that keeps accelerations within ``most`` (dof,) and x from falling below 0."""
    allowed = np.maximum((1.0 - _KEPT) * most, np.abs(bend) * x)
    by_u = np.concatenate([slope[0], slope[1] + 2.0 * step * bend[1]])
    rest = np.concatenate([bend[0], bend[1]]) * x
    room = np.concatenate([allowed[0], allowed[1]])
    with np.errstate(divide="ignore", invalid="ignore"):
        low = np.where(by_u > 0, (-room - rest) / by_u, np.where(by_u < 0, (room - rest) / by_u, -np.inf))
    return min(0.0, max(float(low.max()), -x / (2.0 * step)))


def _through(trajectory: Trajectory, times: Floats, s: Floats, qd: Floats) -> Trajectory:
    """The cubics through the states at ``s`` of the trajectory, at new ``times``."""
    q = trajectory.at(s)
    if len(times) == 1:
        times, q, qd = np.array([0.0, _STEP]), np.repeat(q, 2, axis=0), np.zeros((2, q.shape[1]))
    return Trajectory.through(trajectory.joints, times, q, qd, law="stop")
