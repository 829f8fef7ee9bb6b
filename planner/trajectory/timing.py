"""From a path to a trajectory: corners rounded and shortcuts taken as far as they are proven, the quickest motion."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import OptionError, StateError
from planner.collision.checker import CollisionChecker, configurations
from planner.collision.edge_prover import EdgeProver
from planner.constraints.floor import prove_floor
from planner.kinematics.manipulability import manipulability
from planner.native.compiled import motion_shares
from planner.problem.options import TimeLaw
from planner.problem.request import RoadmapQuality, TimingRequest
from planner.trajectory.curve import (
    Cost,
    Curve,
    average_motion,
    corner_parabolas,
    curve_cost,
    drop_standstills,
    duration_of,
    fastest_phases,
    joint_distance,
    knot_spacing,
    path_segments,
    round_corners,
    shorten,
)
from planner.trajectory.limits import USED, MotionLimits, limits_or_default
from planner.trajectory.proof import MotionProof, prove_motion
from planner.trajectory.trajectory import NANOSECOND, Trajectory

_NARROWEST = 1 / 64  # of the widest rounding of a corner: one that needs less room is stopped at
DEVIATION = 0.02  # rad (m): the motion along a path that is given passes each corner as near as this
_LEAST = 1e-6
_ROUNDED = 0.9  # of it is left to the rounding; the mean that limits the jerk leaves the curve as well
_LOOKS = 129  # moments among which the one nearest to a waypoint is sought
_EXTRA = 1e-7  # by so much more than needed is a motion slowed down that is a little too quick, so that once will do


class Guide(Protocol):
    """What a motion has to keep to along its path, besides limits and obstacles: a tube, and a speed.

    Places along the path are one more column of it: its last, ``along``, which grows from waypoint to waypoint.
    """

    @property
    def along(self) -> Floats: ...  # (k,) of the waypoints
    @property
    def fastest(self) -> float: ...  # how much it may grow per second

    def holds(self, coefficients: Floats, begin: Floats, end: Floats) -> Bools:
        """Which curves (m, degree + 1, dof), from one place (m,) to another (m,), are proven to keep to it."""
        ...


_FREELY = 1e3  # 1/s²: what the places along a path may be accelerated by


@dataclass(frozen=True, eq=False)
class _Asked:
    """What a motion is made for; ``path`` has the guide's places as a last column where there is one."""

    path: Floats
    prover: EdgeProver
    limits: MotionLimits
    floor: float
    guide: Guide | None
    deviation: float
    cost: Cost
    most: float | None  # that a curve with shortcuts may cost; None: none are taken

    @cached_property
    def widest(self) -> Floats:
        """The shares (k - 2,) of half a segment by which corners are rounded at most, for the deviation."""
        off = np.abs(np.diff(self.path[:, : self.dof], n=2, axis=0)).max(axis=1, initial=0.0) / 8.0  # by whole halves
        return np.minimum(1.0, _ROUNDED * self.deviation / np.maximum(off, 1e-300))

    @property
    def dof(self) -> int:
        return self.prover.robot.dof

    @cached_property
    def used(self) -> MotionLimits:
        """The limits that motions are made for: a little less than those they are judged by."""
        return self.limits.scale_all(USED)

    def inside(self, coefficients: Floats, begin: Floats, end: Floats) -> Bools:
        """Which curves keep to the guide; all where there is none."""
        if self.guide is None:
            return np.ones(len(coefficients), dtype=bool)
        return self.guide.holds(coefficients, begin, end)


@dataclass(frozen=True, eq=False)
class _Motion:
    """A motion along a curve whose corners have ``widths`` (k - 2,), and what is proven of it.

    ``piece`` (m,) is that of the curve under each of its own, ``places`` (m + 1, 0 or 1) those of knots along a guide.
    """

    asked: _Asked
    curve: Curve
    widths: Floats
    trajectory: Trajectory
    piece: Ints
    places: Floats

    @cached_property
    def proof(self) -> MotionProof:
        return prove_motion(self.trajectory, self.asked.prover, self.asked.limits, self.asked.floor)

    @cached_property
    def inside(self) -> Bools:
        """(m,) which pieces keep to the guide."""
        begin, end = self.places[:-1, :1].ravel(), self.places[1:, :1].ravel()
        return self.asked.inside(self.trajectory.coefficients, begin, end)


def time_path(
    path: Floats,
    checker: CollisionChecker,
    limits: MotionLimits | None = None,
    *,
    time_law: TimeLaw = "blended",
    deviation: float = DEVIATION,
    floor: float = 0.0,
    cost: Cost = joint_distance,
    extra_cost: float = 0.0,
) -> Trajectory:
    """A motion along a joint path (k, dof) that keeps ``limits``, from rest to rest.

    ``blended`` rounds corners by parabolas and passes every waypoint: no joint is farther from it than ``deviation``
    (rad; m where it slides) at some moment, and a larger one makes the motion quicker. Corners are narrower where that
    is not proven to keep the checker's margin and w above ``floor``, and the motion stops where even narrow ones are
    not; it is the quickest along that curve, but for the milliseconds over which it is averaged to limit the jerk.
    ``stop-at-corners`` stays on the path. ``shortcuts``, which the planner's own paths have, may leave out waypoints
    and loops: it rounds corners by up to half a segment, and takes proven shortcuts in time as long as the curve's
    ``cost`` is at most 1 + ``extra_cost`` times the path's. Each exists for every path. ``proof``
    says what is proven of the result; a path that touches something is timed too, and nothing is proven then. Raises
    :class:`PlannerError` for a path of other joints, without waypoints, or with what is no finite number.
    """
    if not deviation >= _LEAST:
        raise OptionError(f"deviation must be {_LEAST} rad (m) or more, got {deviation:g}: stop-at-corners has none.")
    near = np.inf if time_law == "shortcuts" else deviation
    return time_curve(path, checker, limits, time_law, floor, cost, extra_cost, deviation=near)[0]


def time_curve(
    path: Floats,
    checker: CollisionChecker,
    limits: MotionLimits | None,
    time_law: TimeLaw,
    floor: float,
    cost: Cost = joint_distance,
    extra_cost: float = 0.0,
    guide: Guide | None = None,
    deviation: float = np.inf,
) -> tuple[Trajectory, Curve]:
    """As :func:`time_path`, with the curve that the motion runs along; proven where it keeps to a ``guide`` too.

    Corners of the planner's own paths are rounded by up to half a segment.
    """
    TimingRequest(time_law=time_law, extra_cost=extra_cost)  # refuses what is out of range
    RoadmapQuality(min_manipulability=floor)
    path = configurations(checker, "path", path)
    if not len(path):
        raise StateError("path has no waypoint: give a row of joint values for each, at least one.")
    limits = limits_or_default(limits, checker.robot)
    lifted = path if guide is None else np.column_stack([path, guide.along])
    points, most = drop_standstills(lifted), None
    if time_law == "shortcuts" and len(points) > 1 and guide is None:
        most = (1.0 + extra_cost) * curve_cost(path_segments(points), cost)
    asked = _Asked(points, EdgeProver(checker), limits, floor, guide, deviation, cost, most)
    found, shortcuts = _proven_motion(asked, time_law)
    record = found.proof.to_dict(checker.world.margin, checker.name)
    record |= {"corners": len(found.widths), "corners_blended": int((found.widths > 0).sum()), "shortcuts": shortcuts}
    if guide is not None:
        record |= {"pieces_inside": int(found.inside.sum())}
    proven = found.proof.whole and bool(found.inside.all())
    return replace(found.trajectory, time_law=time_law, limits=limits, proven=proven, proof=record), found.curve


def _proven_motion(asked: _Asked, time_law: TimeLaw) -> tuple[_Motion, int]:
    """The motion along the path, its corners rounded as far as that is proven, and how many shortcuts it takes.

    Where a motion with shortcuts is proven, as nearly all are, none without is asked for.
    """
    corners = max(len(asked.path) - 2, 0)
    widths = _provable_widths(asked) if time_law != "stop-at-corners" and corners else np.zeros(corners)
    curve = round_corners(asked.path, widths)
    if (found := _shortened(asked, curve, widths)) is not None:
        return found
    motion = _motion(asked, curve, widths)
    while (narrower := _narrowed(motion)) is not None:
        motion = _motion(asked, round_corners(asked.path, narrower), narrower)
    if motion.widths is not widths and motion.proof.whole:
        found = _shortened(asked, motion.curve, motion.widths)
    return found or (motion, 0)


def _shortened(asked: _Asked, curve: Curve, widths: Floats) -> tuple[_Motion, int] | None:
    """The motion along a curve with shortcuts, and how many; None where these make nothing quicker that is proven."""
    if asked.most is None:
        return None
    shorter, phases, count, before = shorten(curve, asked.prover, asked.used, asked.floor, asked.cost, asked.most)
    if not count:
        return None
    motion = _motion(asked, shorter, widths, phases)
    takes = motion.trajectory.nanoseconds[-1]
    at_least = duration_of(before) / NANOSECOND  # without the window of the mean
    if takes >= at_least and takes >= _motion(asked, curve, widths, before).trajectory.nanoseconds[-1]:
        return None
    return (motion, count) if motion.proof.whole else None


def _provable_widths(asked: _Asked) -> Floats:
    """The widest of 1, 1/2, ... 1/64 of the allowed width at which a corner's parabola (k - 2,) is proven, else 0."""
    widths = asked.widest.copy()
    # next to a waypoint below the floor the path is itself below it, on its way from the start or to the goal
    above = manipulability(asked.prover.robot, asked.path[:, : asked.dof]) >= asked.floor
    levels = np.where(above[:-2] & above[1:-1] & above[2:], asked.floor, 0.0)
    open_ = np.arange(len(widths))
    while len(open_):
        lifted = corner_parabolas(asked.path, widths)[open_]
        curves = lifted[..., : asked.dof]
        good = asked.prover.prove_curves(curves, contacts=False).free
        near = np.flatnonzero(good)
        good[near] &= asked.inside(curves[near], lifted[near, 0, -1], lifted[near, :, -1].sum(axis=1))
        if asked.floor > 0:
            asks = np.flatnonzero(good & (levels[open_] > 0))
            good[asks] = prove_floor(asked.prover.robot, curves[asks], levels[open_[asks]]).holds
        open_ = open_[~good]
        widths[open_] *= 0.5
        open_ = open_[widths[open_] >= _NARROWEST * asked.widest[open_]]
    return np.where(widths >= _NARROWEST * asked.widest, widths, 0.0)


def _motion(asked: _Asked, curve: Curve, widths: Floats, phases: Floats | None = None) -> _Motion:
    """The smoothed motion along a curve, as slow as it takes to be within limits exactly.

    ``phases``: the quickest motion along it, where that is known.
    """
    limits = asked.used
    spacing = knot_spacing(limits, asked.path[:, : asked.dof])
    if len(asked.path) == 1:
        q = asked.path[[0, 0]]
        still = Trajectory(asked.limits.joints, np.array([0, spacing[0]]), (q, 0.0 * q, 0.0 * q))
        trajectory, places = _without_places(still, asked.dof)
        return _Motion(asked, curve, widths, trajectory, np.zeros(1, dtype=np.int64), places)
    if phases is None:
        velocity, acceleration = limits.velocity, limits.acceleration
        if asked.guide is not None:
            velocity, acceleration = np.append(velocity, asked.guide.fastest), np.append(acceleration, _FREELY)
        phases = fastest_phases(curve, velocity, acceleration)
    stretch = 1.0
    while True:
        lifted, piece = average_motion(curve, phases, stretch, spacing, asked.limits.joints)
        trajectory, places = _without_places(lifted, asked.dof)
        shares = motion_shares(trajectory.nanoseconds, *trajectory.columns, limits.rows).tolist()
        needed = max(share ** (1.0 / order) for order, share in enumerate(shares, start=1))
        if needed <= 1.0:
            return _Motion(asked, curve, widths, trajectory, piece, places)
        stretch *= needed * (1.0 + _EXTRA)


def _without_places(lifted: Trajectory, dof: int) -> tuple[Trajectory, Floats]:
    """The motion of the joints, and the places (k, 0 or 1) of its knots along a guide."""
    places = lifted.columns[0][:, dof:]
    if not places.size:
        return lifted, places
    return replace(lifted, columns=tuple(np.ascontiguousarray(rows[:, :dof]) for rows in lifted.columns)), places


def _narrowed(motion: _Motion) -> Floats | None:
    """Half the width for corners next to which something is not proven, or that are passed too far away; else None."""
    bad = np.flatnonzero((motion.proof.verdict != 0) | ~motion.proof.floor_holds | ~motion.inside)
    pieces, corner = motion.piece[bad], motion.curve.corner
    near = np.unique(np.concatenate([pieces, pieces - 1, pieces + 1]).clip(0, len(corner) - 1))
    corners = corner[near]
    corners = np.append(corners[corners > 0] - 1, _passed_too_far_away(motion))
    if not len(corners):
        return None
    narrower = motion.widths.copy()
    narrower[corners] *= 0.5
    return np.where(narrower >= _NARROWEST * motion.asked.widest, narrower, 0.0)


def _passed_too_far_away(motion: _Motion) -> Ints:
    """The rounded corners (m,) that the motion, averaged to limit the jerk, passes farther away than the deviation."""
    asked, rounded = motion.asked, np.flatnonzero(motion.curve.corner > 0)
    if not len(rounded) or np.isinf(asked.deviation):
        return np.zeros(0, dtype=np.int64)
    trajectory, corner = motion.trajectory, motion.curve.corner[rounded]
    first, behind = (np.searchsorted(motion.piece, rounded, side=side) for side in ("left", "right"))
    window, _ = knot_spacing(asked.used, asked.path[:, : asked.dof])
    clock = np.linspace(trajectory.nanoseconds[first], trajectory.nanoseconds[behind] + window, _LOOKS) * NANOSECOND
    q = trajectory.at(clock.ravel()).reshape(_LOOKS, len(corner), -1)
    off = np.abs(q - asked.path[corner, : asked.dof]).max(axis=2).min(axis=0)
    return corner[off > asked.deviation] - 1
