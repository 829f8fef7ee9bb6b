"""The judge on what the gate calls safe: the controller's own splines looked at closely, and limits by roots.

It shares nothing with the gate but the collision libraries, coal and FCL, which are asked about states alone.
"""

# pyright: reportAttributeAccessIssue=false
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.gate.chunks import KINDS, Chunk
from planner.base.arrays import Floats
from planner.collision.checker import CollisionChecker
from planner.gate.verdict import Verdict
from planner.kinematics.forward import joint_placements
from planner.trajectory.limits import MotionLimits

LOOKS = 16e-3, 2e-3, 5e-5  # m between two states: of each look, where something is as near as the one before


@dataclass(frozen=True, eq=False)
class Spline:
    """A polynomial (degree + 1, dof) of t in [0, seconds], from ``begin`` s on."""

    begin: float
    seconds: float
    powers: Floats

    def at(self, t: Floats, order: int = 0) -> Floats:
        """Values (n, dof) at ``t`` (n,) s since its begin, or a derivative."""
        c = self.powers
        for _ in range(order):
            c = c[1:] * np.arange(1, len(c))[:, None] if len(c) > 1 else 0.0 * c
        return np.vander(t, len(c), increasing=True) @ c

    def largest(self, order: int) -> Floats:
        """The largest absolute value (dof,) of a derivative, at both ends and where the next one is 0."""
        found = np.abs(self.at(np.array([0.0, self.seconds]), order)).max(axis=0)
        for j in range(self.powers.shape[1]):
            slope = np.polynomial.Polynomial(self.powers[:, j]).deriv(order + 1)
            roots = np.atleast_1d(slope.roots()) if slope.degree() else np.zeros(0)
            real = np.asarray(roots.real, dtype=np.float64)
            inner = real[(np.abs(roots.imag) < 1e-9) & (real > 0) & (real < self.seconds)]
            if len(inner):
                found[j] = max(found[j], np.abs(self.at(inner, order)[:, j]).max())
        return found


def spline(begin: float, seconds: float, first: Floats, last: Floats) -> Spline:
    """The polynomial with the values and derivatives (rows, dof) at both ends: rows = 1, 2 or 3."""
    rows = len(first)
    conditions = []
    for t in (0.0, seconds):
        for order in range(rows):
            conditions.append([_slope(power, order) * t ** max(power - order, 0) for power in range(2 * rows)])
    powers = np.linalg.solve(np.array(conditions), np.concatenate([first, last]))
    return Spline(begin, seconds, np.asarray(powers, dtype=np.float64))


def _slope(power: int, order: int) -> float:
    return float(np.prod(np.arange(power, power - order, -1))) if power >= order else 0.0


def motion_of(chunk: Chunk) -> list[Spline]:
    """What a controller runs of a chunk."""
    rows = KINDS.index(chunk.kind) + 1
    return [
        spline(float(t), float(end - t), a[:rows], b[:rows])
        for t, end, a, b in zip(chunk.times, chunk.times[1:], chunk.knots, chunk.knots[1:], strict=False)
    ]


def stops_of(chunk: Chunk, verdict: Verdict) -> list[Spline] | None:
    """The stops that the verdict has from every target on; None where it has none for one."""
    found: list[Spline] = []
    for k, t in enumerate(chunk.times[1:].tolist(), 1):
        stop = verdict._judged.stop(k)
        if stop is None:
            return None
        ends = np.stack(stop.columns, axis=1)
        parts = zip(stop.times.tolist(), stop.seconds.tolist(), ends, ends[1:], strict=False)
        found += [spline(t + begin, seconds, first, last) for begin, seconds, first, last in parts]
    return found


def possible_stops(verdict: Verdict) -> list[Spline] | None:
    """The stops that limits allow from every target on, proven or not; None where one has none."""
    pieces, seconds, _ = verdict._judged.stops_from(verdict._judged.chunk.knots[1:])
    if not seconds[:, 1].all():
        return None
    return [
        Spline(0.0, float(t), c / t ** np.arange(len(c))[:, None])
        for c, t in zip(pieces.reshape(-1, *pieces.shape[2:]), seconds.ravel(), strict=True)
        if t > 0
    ]


def beyond_limits(motion: Sequence[Spline], stops: Sequence[Spline], limits: MotionLimits, kind: str) -> float:
    """The largest share of a limit, beyond 1, that the motion or a stop has of what is judged; 0 for none."""
    judged, worst = KINDS.index(kind) + 1, 0.0
    for curves, count in ((motion, judged), (stops, 3)):
        for one in curves:
            for order in range(1, count + 1):
                most = (limits.velocity, limits.acceleration, limits.jerk)[order - 1]
                worst = max(worst, float((one.largest(order) / most).max()) - 1.0)
    return worst if worst > 1e-5 else 0.0


def states_on(curve: Spline, checker: CollisionChecker, apart: float) -> Floats:
    """States (n, dof) on a curve between which no point moves farther than ``apart`` (m)."""
    moved = _fastest(curve, checker) * curve.seconds
    return curve.at(np.linspace(0.0, curve.seconds, int(np.ceil(moved / apart)) + 2))


def _fastest(curve: Spline, checker: CollisionChecker) -> float:
    """How fast (m/s) a point moves at most; of the speed at 33 moments 5 % more."""
    speed = 1.05 * np.abs(curve.at(np.linspace(0.0, curve.seconds, 33), 1)).max(axis=0)
    return max(float(checker.world.reach.motion(speed[None]).max(initial=0.0)), 1e-9)


def nearest(curve: Spline, judge: CollisionChecker) -> tuple[float, Floats]:
    """The smallest distance (m) seen to an obstacle, and the times (n,) every 0.05 mm where that is 2 mm or less.

    First every 16 mm: what comes between two states comes nearer to one of them than they are apart.
    """
    checked = judge.world.checked.ravel()
    pairs = np.flatnonzero(checked & judge.world.moving[: len(checked)])
    fastest = _fastest(curve, judge)
    t, least = np.linspace(0.0, curve.seconds, int(np.ceil(fastest * curve.seconds / LOOKS[0])) + 2), np.inf
    for apart, finer in zip(LOOKS, (*LOOKS[1:], 0.0), strict=True):
        if not finer or not len(t):
            return least, t
        rotation, position = joint_placements(judge.chain, curve.at(t))
        gaps = np.array([judge.distances(rotation[:, k], position[:, k], pairs).min() for k in range(len(t))])
        least = min(least, float(gaps.min()))
        around = np.linspace(-0.5, 0.5, 2 * int(np.ceil(apart / finer)) + 1) * 2.0 * apart / fastest
        t = np.unique(np.clip((t[gaps <= apart][:, None] + around).ravel(), 0.0, curve.seconds))
    return least, t


def touches(curves: Sequence[Spline], judges: Sequence[CollisionChecker]) -> tuple[float, bool]:
    """The smallest distance (m) that the first of the ``judges`` sees, and whether one of them sees a contact."""
    least, touched = np.inf, False
    for curve in curves:
        gap, times = nearest(curve, judges[0])
        least = min(least, gap)
        states = curve.at(np.concatenate([times, np.linspace(0.0, curve.seconds, 20)]))  # links may meet anywhere
        touched = touched or any(judge.first_contact(states) is not None for judge in judges)
    return least, touched
