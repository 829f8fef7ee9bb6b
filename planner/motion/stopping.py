"""Braking at any moment of a trajectory, along the same curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.motion.limits import MotionLimits
from planner.motion.trajectory import Trajectory

_STEP = 2e-3  # s of the trajectory between two changes of the braking, at most
_STILL = 1e-9  # rad/s: no motion to brake
_AT_REST = 1e-12  # of x: nothing is left but rounding
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
    if np.abs(trajectory.at(t, 1)).max() < _STILL:
        q = np.repeat(trajectory.at(t), 2, axis=0)
        return Stop(Trajectory.through(trajectory.joints, np.array([0.0, _STEP]), q, 0.0 * q, law="stop"), t, 0.0)
    s = _grid(trajectory, t)
    slope, bend = trajectory.at(s, 1), trajectory.at(s, 2)
    x, moments, clock = [1.0], [t], [0.0]
    for k, step in enumerate(np.diff(s).tolist()):
        u = _least(slope[k : k + 2], bend[k : k + 2], x[-1], step, limits.acceleration)
        step = min(step, -0.5 * x[-1] / u) if u < 0 else step  # it may come to rest on the way
        x.append(max(0.0, x[-1] + 2.0 * step * u) if moments[-1] + step < s[-1] else 0.0)
        moments.append(moments[-1] + step)
        clock.append(clock[-1] + 2.0 * step / (np.sqrt(x[-2]) + np.sqrt(x[-1])))
        if x[-1] < _AT_REST:
            break
    x[-1] = 0.0
    made = _through(trajectory, np.array(clock), np.array(moments), np.sqrt(x)[:, None])
    shares = [(made.largest(1) / limits.velocity).max(), (made.largest(2) / limits.acceleration).max()]
    return Stop(made, moments[-1], max(0.0, float(max(shares)) - 1.0))


def _grid(trajectory: Trajectory, t: float) -> Floats:
    """Moments (n,) from ``t`` to the end: the knots, and others so that none is more than ``_STEP`` after the last."""
    count = max(1, int(np.ceil((trajectory.times[-1] - t) / _STEP)))
    even = np.linspace(t, trajectory.times[-1], count + 1)
    s = np.union1d(trajectory.times[trajectory.times > t], even)
    kept = s[np.concatenate([[True], np.diff(s) > 0.1 * _STEP])]
    return np.concatenate([kept[:-1], s[-1:]]) if len(kept) > 1 else np.array([t, max(s[-1], t + _STEP)])


def _least(slope: Floats, bend: Floats, x: float, step: float, most: Floats) -> float:
    """The least u, 0 at most, that keeps accelerations within ``most`` (dof,) at both ends of an interval."""
    allowed = np.maximum((1.0 - _KEPT) * most, np.abs(bend) * x)
    by_u = np.concatenate([slope[0], slope[1] + 2.0 * step * bend[1]])
    rest = np.concatenate([bend[0], bend[1]]) * x
    room = np.concatenate([allowed[0], allowed[1]])
    with np.errstate(divide="ignore", invalid="ignore"):
        low = np.where(by_u > 0, (-room - rest) / by_u, np.where(by_u < 0, (room - rest) / by_u, -np.inf))
    return min(0.0, float(low.max()))


def _through(trajectory: Trajectory, times: Floats, s: Floats, speed: Floats) -> Trajectory:
    """The cubics through the trajectory's states at ``s`` (n,), run through at ``times`` (n,) with ``speed`` (n, 1)."""
    return Trajectory.through(trajectory.joints, times, trajectory.at(s), speed * trajectory.at(s, 1), law="stop")
