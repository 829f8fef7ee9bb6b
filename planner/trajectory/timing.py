"""From a path to a trajectory: corners rounded and shortcuts taken as far as they are proven, the quickest motion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import StateError
from planner.base.kinds import checks_kinds
from planner.collision.checker import CollisionChecker, configurations
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.manipulability import manipulability
from planner.kinematics.manipulability_proof import prove_floor
from planner.problem.request import DEFAULT_TIME_LAW, TimeLaw, require_timing
from planner.trajectory.curve import Curve, blends, rounded, straight, without_standstill
from planner.trajectory.limits import KINDS, USED, MotionLimits
from planner.trajectory.proof import MotionProof, prove_motion
from planner.trajectory.smoothing import Spacing, Timed, knots_of, smoothed, standstill
from planner.trajectory.time_optimal import quickest
from planner.trajectory.time_shortcuts import Cost, Shortcuts, curve_cost, joint_motion
from planner.trajectory.trajectory import Trajectory

_NARROWEST = 1 / 64  # of half a segment: a corner that needs less room is stopped at
_EXTRA = 1e-7  # by so much more than needed is a motion slowed down that is a little too quick, so that once will do


@dataclass(frozen=True, eq=False)
class _Asked:
    """What a motion is made for."""

    path: Floats
    prover: EdgeProver
    limits: MotionLimits
    floor: float


@dataclass(frozen=True, eq=False)
class _Motion:
    """A motion along a curve."""

    curve: Curve
    timed: Timed

    @property
    def nanoseconds(self) -> int:
        """How long it takes."""
        return int(self.timed.nanoseconds[-1])

    def proven_for(self, asked: _Asked, widths: Floats) -> _Proven:
        """The same with what is proven of it."""
        trajectory = self.timed.trajectory(asked.limits.joints, "")
        proof = prove_motion(trajectory, asked.prover, asked.limits, asked.floor)
        return _Proven(self.curve, self.timed, proof, widths)


@dataclass(frozen=True, eq=False)
class _Proven(_Motion):
    """And what is proven of it; ``widths`` (k - 2,) of the path's corners, where they are rounded."""

    proof: MotionProof
    widths: Floats


@checks_kinds
def time_path(
    path: Floats,
    checker: CollisionChecker,
    limits: MotionLimits | None = None,
    *,
    law: TimeLaw = DEFAULT_TIME_LAW,
    floor: float = 0.0,
    cost: Cost = joint_motion,
    extra_cost: float = 0.0,
) -> Trajectory:
    """A motion along a joint path (k, dof) that keeps ``limits``, from rest to rest.

    ``blended`` rounds corners by parabolas, as wide as half the segments where that is proven to keep the checker's
    margin and w above ``floor``, narrower where it is not, and stops where even narrow ones are not; the motion is the
    quickest along that curve, but for the milliseconds over which it is averaged to limit the jerk. ``shortcuts`` takes
    proven shortcuts in time as well, as long as the curve's ``cost`` is at most 1 + ``extra_cost`` times the path's:
    the larger, the quicker the motion. ``stop-at-corners`` stays on the path. Each exists for every path. ``proof``
    says what is proven of the result; a path that touches something is timed too, and nothing is proven then. Raises
    :class:`PlannerError` for a path of other joints, without waypoints, or with what is no finite number.
    """
    return timed_curve(path, checker, limits, law, floor, cost, extra_cost)[0]


def timed_curve(
    path: Floats,
    checker: CollisionChecker,
    limits: MotionLimits | None,
    law: TimeLaw,
    floor: float,
    cost: Cost = joint_motion,
    extra_cost: float = 0.0,
) -> tuple[Trajectory, Curve]:
    """As :func:`time_path`, with the curve that the motion runs along."""
    require_timing(law, floor, extra_cost)
    path = configurations(checker, "path", path)
    if not len(path):
        raise StateError("path has no waypoint: give a row of joint values for each, at least one.")
    limits = limits or MotionLimits.of(checker.robot)
    asked = _Asked(without_standstill(path), EdgeProver(checker), limits, floor)
    rules = None
    if law == "shortcuts" and len(asked.path) > 1:
        most = (1.0 + extra_cost) * curve_cost(straight(asked.path), cost)
        rules = Shortcuts(asked.prover, limits.times(USED), floor, cost, most)
    found, shortcuts = _proven_motion(asked, law, rules)
    record = found.proof.to_dict(checker.world.margin, checker.name)
    record |= {"corners": len(found.widths), "corners_blended": int((found.widths > 0).sum()), "shortcuts": shortcuts}
    made = found.timed.trajectory(limits.joints, law)
    return replace(made, limits=limits, proven=found.proof.whole, proof=record), found.curve


def _proven_motion(asked: _Asked, law: TimeLaw, rules: Shortcuts | None) -> tuple[_Proven, int]:
    """The motion along the path with its corners rounded as far as that is proven, and shortcuts where there are rules.

    And how many shortcuts. Where a motion with shortcuts is proven, as nearly all are, none without is asked for.
    """
    corners = max(len(asked.path) - 2, 0)
    widths = _provable_widths(asked) if law != "stop-at-corners" and corners else np.zeros(corners)
    motion = _motion(asked, rounded(asked.path, widths))
    if (found := _shortened(asked, motion, widths, rules)) is not None:
        return found
    proven = motion.proven_for(asked, widths)
    while (narrower := _narrowed(proven)) is not None:
        proven = _motion(asked, rounded(asked.path, narrower)).proven_for(asked, narrower)
    if proven.widths is not widths and proven.proof.whole:
        found = _shortened(asked, proven, proven.widths, rules)
    return found or (proven, 0)


def _shortened(asked: _Asked, motion: _Motion, widths: Floats, rules: Shortcuts | None) -> tuple[_Proven, int] | None:
    """The motion with shortcuts, and how many; None where these make nothing quicker that is proven."""
    if rules is None:
        return None
    curve, count = rules.shorten(motion.curve)
    shorter = _motion(asked, curve) if count else motion
    if shorter.nanoseconds >= motion.nanoseconds:
        return None
    proven = shorter.proven_for(asked, widths)
    return (proven, count) if proven.proof.whole else None


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


def _motion(asked: _Asked, curve: Curve) -> _Motion:
    """The smoothed motion along a curve, as slow as it takes to be within limits exactly."""
    limits = asked.limits.times(USED)
    spacing = Spacing.of(limits, asked.path)
    if len(asked.path) == 1:
        return _Motion(curve, standstill(asked.path[0], spacing.window))
    phases = quickest(curve, limits.velocity, limits.acceleration)
    stretch, timed, needed = 1.0, None, np.inf
    while timed is None or needed > 1.0:
        timed = smoothed(knots_of(curve, phases, stretch, spacing), spacing)
        needed = _stretch_needed(timed, limits)
        stretch *= needed * (1.0 + _EXTRA)
    return _Motion(curve, timed)


def _stretch_needed(timed: Timed, limits: MotionLimits) -> float:
    """By how much the motion would have to be slower to keep all limits: 1 or less where it does."""
    trajectory = timed.trajectory(limits.joints, "")
    shares = [trajectory.worst(order, getattr(limits, kind), 1.0)[0] for order, kind in enumerate(KINDS, start=1)]
    return float(max(share ** (1.0 / order) for order, share in enumerate(shares, start=1)))


def _narrowed(motion: _Proven) -> Floats | None:
    """Half the width for corners next to which something is not proven; None where there is nothing to narrow."""
    bad = np.flatnonzero((motion.proof.verdict != 0) | ~motion.proof.floor_holds)
    pieces, corner = motion.timed.piece[bad], motion.curve.corner
    near = np.unique(np.concatenate([pieces, pieces - 1, pieces + 1]).clip(0, len(corner) - 1))
    corners = corner[near]
    corners = corners[corners > 0] - 1
    if not len(corners):
        return None
    narrower = motion.widths.copy()
    narrower[corners] *= 0.5
    return np.where(narrower >= _NARROWEST, narrower, 0.0)
