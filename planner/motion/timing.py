"""From a path to a trajectory: corners rounded as far as proofs allow, the quickest motion, proven once more."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats
from planner.base.request import TimeLaw
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.manipulability import manipulability
from planner.kinematics.manipulability_proof import prove_floor
from planner.motion.curve import Curve, blends, rounded, without_standstill
from planner.motion.limits import KINDS, MotionLimits
from planner.motion.proof import MotionProof, prove_motion
from planner.motion.smoothing import Timed, knots_of, smoothed, window_for
from planner.motion.time_optimal import quickest
from planner.motion.trajectory import Trajectory

_NARROWEST = 1 / 64  # of half a segment: a corner that needs less room is stopped at
USED = 0.999  # share of every limit that motions use, so that braking along the same curve can keep to all of it
_EXTRA = 1e-7  # by so much more than needed is a motion slowed down that is a little too quick, so that once will do


@dataclass(frozen=True, eq=False)
class _Asked:
    """What a motion is made for."""

    path: Floats
    prover: EdgeProver
    limits: MotionLimits
    floor: float


def time_path(
    path: Floats,
    checker: CollisionChecker,
    limits: MotionLimits | None = None,
    *,
    law: TimeLaw = "blended",
    floor: float = 0.0,
) -> Trajectory:
    """A motion along a joint path (k, dof) that keeps ``limits``, from rest to rest.

    ``blended`` rounds corners by parabolas, as wide as half the segments where that is proven to keep the checker's
    margin and w above ``floor``, narrower where it is not, and stops where even narrow ones are not; the motion is the
    quickest along that curve, but for the milliseconds over which it is averaged to limit the jerk. ``stop-at-corners``
    stays on the path. Either exists for every path. ``proof`` says what is proven of the result; a path that touches
    something is timed too, and nothing is proven then.
    """
    return timed_curve(path, checker, limits, law, floor)[0]


def timed_curve(
    path: Floats, checker: CollisionChecker, limits: MotionLimits | None, law: TimeLaw, floor: float
) -> tuple[Trajectory, Curve]:
    """As :func:`time_path`, with the rounded path that the motion runs along."""
    robot = checker.robot
    asked = _Asked(
        without_standstill(np.asarray(path, dtype=float)), EdgeProver(checker), MotionLimits.of(robot), floor
    )
    asked = replace(asked, limits=limits or asked.limits)
    corners = max(len(asked.path) - 2, 0)
    widths = _provable_widths(asked) if law == "blended" and corners else np.zeros(corners)
    while True:
        timed, curve = _motion(asked.path, widths, asked.limits.times(USED))
        trajectory = timed.trajectory(robot.joints, law)
        proof = prove_motion(trajectory, asked.prover, asked.limits, floor)
        narrower = _narrowed(widths, timed, curve, proof)
        if narrower is None:
            break
        widths = narrower
    record = proof.to_dict(checker.world.margin, checker.name)
    record |= {"corners": corners, "corners_blended": int((widths > 0).sum())}
    return replace(trajectory, limits=asked.limits, proven=proof.whole, proof=record), curve


def _provable_widths(asked: _Asked) -> Floats:
    """The widest of 1, 1/2, ... 1/64 at which each corner's parabola (k - 2,) is proven, else 0."""
    widths = np.ones(len(asked.path) - 2)
    levels = _levels(asked)
    open_ = np.arange(len(widths))
    while len(open_):
        curves = blends(asked.path, widths)[open_]
        good = asked.prover.prove_curves(curves).free
        if asked.floor > 0:
            asks = np.flatnonzero(good & (levels[open_] > 0))
            good[asks] = prove_floor(asked.prover.robot, curves[asks], levels[open_[asks]]).holds
        open_ = open_[~good]
        widths[open_] *= 0.5
        open_ = open_[widths[open_] >= _NARROWEST]
    return np.where(widths >= _NARROWEST, widths, 0.0)


def _levels(asked: _Asked) -> Floats:
    """The w that each inner waypoint's parabola (k - 2,) has to keep to: the floor, 0 next to a waypoint below it.

    There the path itself is below the floor, on its way from the start or to the goal.
    """
    above = manipulability(asked.prover.robot, asked.path) >= asked.floor
    return np.where(above[:-2] & above[1:-1] & above[2:], asked.floor, 0.0)


def _motion(path: Floats, widths: Floats, limits: MotionLimits) -> tuple[Timed, Curve]:
    """The smoothed motion along the rounded path, as slow as it takes to be within limits exactly."""
    window = window_for(limits.acceleration, limits.jerk)
    if len(path) == 1:
        rest = Timed(np.array([0, window]), np.repeat(path, 2, axis=0), np.zeros((2, path.shape[1])), np.zeros(1, int))
        return rest, Curve(np.stack([path, 0 * path, 0 * path], axis=1), np.array([-1]), np.array([True]))
    curve = rounded(path, widths)
    phases = quickest(curve, limits.velocity, limits.acceleration)
    stretch, timed, needed = 1.0, None, np.inf
    while timed is None or needed > 1.0:
        timed = smoothed(knots_of(curve, phases, stretch, window), window)
        needed = _stretch_needed(timed, limits)
        stretch *= needed * (1.0 + _EXTRA)
    return timed, curve


def _stretch_needed(timed: Timed, limits: MotionLimits) -> float:
    """By how much the motion would have to be slower to keep all limits: 1 or less where it does."""
    trajectory = timed.trajectory(limits.joints, "")
    shares = [(trajectory.largest(order) / getattr(limits, kind)).max() for order, kind in enumerate(KINDS, start=1)]
    return float(max(share ** (1.0 / order) for order, share in enumerate(shares, start=1)))


def _narrowed(widths: Floats, timed: Timed, curve: Curve, proof: MotionProof) -> Floats | None:
    """Half the width for corners next to which something is not proven; None where there is nothing to narrow."""
    bad = np.flatnonzero((proof.verdict != 0) | ~proof.floor_holds)
    pieces = timed.piece[bad]
    near = np.unique(np.concatenate([pieces, pieces - 1, pieces + 1]).clip(0, len(curve.corner) - 1))
    corners = curve.corner[near]
    corners = corners[corners > 0] - 1
    if not len(corners):
        return None
    narrower = widths.copy()
    narrower[corners] *= 0.5
    return np.where(narrower >= _NARROWEST, narrower, 0.0)
