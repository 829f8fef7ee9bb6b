"""Shortcuts in time along a rounded path: parabolic ramps between two of its moments (Hauser and Ng-Thow-Hing 2010).

Between two states of the motion, position and velocity, every joint takes its own parabolic ramp, all in the same time.
Where that takes less time than the motion did, is proven to keep clear and above the manipulability floor, and leaves
the cost of the whole within what is allowed, it takes the place of what lies between. Ramps are parabolas, as rounded
corners are: the path stays a curve of lines and parabolas, along which the quickest motion is found anew.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Floats
from planner.collision.edge_prover import EdgeProver
from planner.collision.path_moves import Ramp, next_ramp
from planner.kinematics.manipulability import prove_floor
from planner.native.compiled import curve_chords
from planner.query.resolve import position_bounds
from planner.trajectory.curve import Curve, duration_of, quickest, spliced
from planner.trajectory.limits import MotionLimits

TRIES = 60  # with twice as many motions take 2 % less, and timing them 1.6 times as long
_SHARES = np.linspace(0.3, 0.98, 35)  # of the time between two moments: how long a ramp may take
_SHORTEST = 0.05  # of the motion: moments nearer than this are not joined
_POINTS = 16  # per piece, between which its length is measured
_CHORD = 0.1  # rad (m): the cost is measured along chords that are about as long, or longer
_LEAST = 1e-12  # rad (m)
_STILL = 1e-9  # of the velocity at a ramp's other end: rest

Cost = Callable[[Floats, Floats], Floats]


def joint_motion(a: Floats, b: Floats) -> Floats:
    """(k,) lengths from configurations ``a`` (k, dof) to ``b`` (k, dof): the cost where no other is given."""
    return np.sqrt(((b - a) ** 2).sum(axis=1))


def curve_cost(pieces: Floats, cost: Cost) -> float:
    """What pieces (m, 3, dof) cost: along chords, each as much more as the curve is longer there."""
    points, walked = curve_chords(pieces, _POINTS, _CHORD)
    start, end = points[:-1], points[1:]
    return float((cost(start, end) * walked / np.maximum(joint_motion(start, end), _LEAST)).sum())


class Shortened(NamedTuple):
    """A curve with shortcuts, the phases of the ``quickest`` motion along it, and those ``before``, without them."""

    curve: Curve
    quickest: Floats
    shortcuts: int
    before: Floats


@dataclass(frozen=True, eq=False)
class Shortcuts:
    """What shortcuts keep to: proofs, the ``floor`` under w, ``limits``, and what the whole costs.

    ``cost`` gives that of straight motions from (k, dof) to (k, dof); for the whole curve it stays below ``most``, or
    where it is beyond already below what it is.
    """

    prover: EdgeProver
    limits: MotionLimits
    floor: float
    cost: Cost
    most: float

    def shorten(self, curve: Curve) -> Shortened:
        """The curve with shortcuts in place of what takes longer."""
        draws = np.random.default_rng(0).random((TRIES, 2))
        spans = np.array([_SHORTEST**draw for draw in draws[:, 0].tolist()])
        spent, tried, found = curve_cost(curve.coefficients, self.cost), 0, 0
        phases = before = self._quickest(curve)
        while (next_ := self._next_ramp(curve, phases, spans[tried:], draws[tried:, 1])) is not None:
            number, start, end, ramp = next_
            tried += number + 1
            shorter = spliced(curve, start, _without_rest(ramp), end)
            costs = curve_cost(shorter.coefficients, self.cost)
            if costs <= max(self.most, spent) and self._above_floor(ramp):
                curve, spent, found = shorter, costs, found + 1
                phases = self._quickest(curve)
        return Shortened(curve, phases, found, before)

    def _quickest(self, curve: Curve) -> Floats:
        return quickest(curve, self.limits.velocity, self.limits.acceleration)

    def _next_ramp(self, curve: Curve, phases: Floats, spans: Floats, draws: Floats) -> Ramp | None:
        """The next proven ramp between two moments of the motion, ``spans`` (k,) of it apart, that takes less time."""
        duration = duration_of(phases)
        spans = duration * spans
        early = draws * (duration - spans)
        moments, positions = np.stack([early, early + spans], axis=1), position_bounds(self.prover.robot)
        limits = self.limits.velocity, self.limits.acceleration
        return next_ramp(self.prover, curve.coefficients, phases, moments, _SHARES, limits, positions)

    def _above_floor(self, ramp: Floats) -> bool:
        return self.floor <= 0 or bool(prove_floor(self.prover.robot, ramp, self.floor).holds.all())


def _without_rest(ramp: Floats) -> Floats:
    """The ramp (m, 3, dof) with lines, whose parameter moves there, where it begins or ends at rest.

    There its direction does not change: velocities grow in proportion to the accelerations.
    """
    made = ramp.copy()
    for k, s in ((0, 0.0), (-1, 1.0)):
        start, slope, bend = ramp[k]
        at, other = np.abs(slope + 2.0 * s * bend).max(), np.abs(slope + 2.0 * (1.0 - s) * bend).max()
        if at <= _STILL * other:
            made[k] = np.stack([start, slope + bend, np.zeros_like(bend)])
    return made
