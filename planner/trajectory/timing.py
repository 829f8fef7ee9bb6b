"""Timing of a path: rounded corners and shortcuts as far as they are proven, and the fastest motion."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import OptionError, StateError
from planner.collision.checker import CollisionChecker, as_configurations
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

_NARROWEST = 1 / 64  # of the widest rounding: the motion stops at a corner that would need a narrower one
DEVIATION = 0.02  # rad (m): largest distance to a corner of a given path
_LEAST = 1e-6
_ROUNDED = 0.9  # of the deviation is for the rounding; the smoothing of the jerk leaves the curve as well
_SAMPLES = 129  # moments per corner, to find the distance to its waypoint
_EXTRA = 1e-7  # safety factor on the slow-down, so that one iteration suffices


class Guide(Protocol):
    """A tube and a speed that a motion keeps to along its path, besides limits and obstacles.

    The guide adds a column to the path: ``along``, which grows from waypoint to waypoint.
    """

    @property
    def along(self) -> Floats: ...  # (k,) of the waypoints
    @property
    def fastest(self) -> float: ...  # largest growth per second

    def holds(self, coefficients: Floats, begin: Floats, end: Floats) -> Bools:
        """Return which curves (m, degree + 1, dof) are proven to stay inside from ``begin`` to ``end`` (m,)."""
        ...


_FREELY = 1e3  # 1/s²: acceleration limit of the guide's column, which never binds


@dataclass(frozen=True, eq=False)
class _Problem:
    """The input of a timing; with a guide, ``path`` has ``along`` as its last column."""

    path: Floats
    prover: EdgeProver
    limits: MotionLimits
    floor: float
    guide: Guide | None
    deviation: float
    cost: Cost
    most: float | None  # largest cost of a curve with shortcuts; None: without shortcuts

    @cached_property
    def widest(self) -> Floats:
        """The shares (k - 2,) of half a segment by which corners are rounded at most, for the deviation."""
        off = np.abs(np.diff(self.path[:, : self.dof], n=2, axis=0)).max(axis=1, initial=0.0) / 8.0  # at share 1
        return np.minimum(1.0, _ROUNDED * self.deviation / np.maximum(off, 1e-300))

    @property
    def dof(self) -> int:
        return self.prover.robot.dof

    @cached_property
    def used(self) -> MotionLimits:
        """The limits that motions are made for, slightly below those that they are checked against."""
        return self.limits.scale_all(USED)

    def is_inside(self, coefficients: Floats, begin: Floats, end: Floats) -> Bools:
        """Return which curves stay inside the guide; all without one."""
        if self.guide is None:
            return np.ones(len(coefficients), dtype=bool)
        return self.guide.holds(coefficients, begin, end)


@dataclass(frozen=True, eq=False)
class _Motion:
    """A motion along a curve with corner ``widths`` (k - 2,), and its proof.

    ``piece`` (m,) is the curve's piece under each of its own; ``guide_places`` (m + 1, 0 or 1) are its knots along a
    guide.
    """

    problem: _Problem
    curve: Curve
    widths: Floats
    trajectory: Trajectory
    piece: Ints
    guide_places: Floats

    @cached_property
    def proof(self) -> MotionProof:
        return prove_motion(self.trajectory, self.problem.prover, self.problem.limits, self.problem.floor)

    @cached_property
    def is_inside(self) -> Bools:
        """(m,) which pieces stay inside the guide."""
        begin, end = self.guide_places[:-1, :1].ravel(), self.guide_places[1:, :1].ravel()
        return self.problem.is_inside(self.trajectory.coefficients, begin, end)


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
    """Return a motion along a joint path (k, dof) that keeps ``limits``, from rest to rest.

    ``blended`` rounds corners by parabolas and passes every waypoint within ``deviation`` (rad; m for sliding joints)
    of each joint; a larger one makes the motion faster. Corners are narrower where that is not proven to keep the
    checker's margin and w above ``floor``, and the motion stops where even narrow ones are not. The motion is the
    fastest one along that curve, apart from the milliseconds of averaging that limit the jerk. ``stop-at-corners``
    stays on the path. ``shortcuts``, the default for the planner's own paths, may leave out waypoints and loops: it
    rounds corners by up to half a segment, and takes proven shortcuts in time while the curve's ``cost`` is at most 1 +
    ``extra_cost`` times the path's.

    Every path has a motion under each law. ``proof`` holds the proofs of the result; a path with a contact is timed as
    well, and then ``proven`` is False. Raises :class:`PlannerError` for a path of other joints, without waypoints, or
    with numbers that are not finite.
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
    """Return the motion as :func:`time_path` does, and its curve; ``proven`` includes the ``guide``.

    By default corners are rounded by up to half a segment.
    """
    TimingRequest(time_law=time_law, extra_cost=extra_cost)  # checks the ranges
    RoadmapQuality(min_manipulability=floor)
    path = as_configurations(checker, "path", path)
    if not len(path):
        raise StateError("path has no waypoint: give a row of joint values for each, at least one.")
    limits = limits_or_default(limits, checker.robot)
    lifted = path if guide is None else np.column_stack([path, guide.along])
    points, most = drop_standstills(lifted), None
    if time_law == "shortcuts" and len(points) > 1 and guide is None:
        most = (1.0 + extra_cost) * curve_cost(path_segments(points), cost)
    problem = _Problem(points, EdgeProver(checker), limits, floor, guide, deviation, cost, most)
    result, shortcuts = _build_motion(problem, time_law)
    record = result.proof.to_dict(checker.world.margin, checker.name)
    record |= {"corners": len(result.widths), "corners_blended": int((result.widths > 0).sum()), "shortcuts": shortcuts}
    if guide is not None:
        record |= {"pieces_inside": int(result.is_inside.sum())}
    proven = result.proof.whole and bool(result.is_inside.all())
    return replace(result.trajectory, time_law=time_law, limits=limits, proven=proven, proof=record), result.curve


def _build_motion(problem: _Problem, time_law: TimeLaw) -> tuple[_Motion, int]:
    """Return the motion along the path with its corners as wide as is proven, and its number of shortcuts.

    Most motions with shortcuts are proven, so the motion without them is built only if they are not.
    """
    corners = max(len(problem.path) - 2, 0)
    widths = _find_provable_widths(problem) if time_law != "stop-at-corners" and corners else np.zeros(corners)
    curve = round_corners(problem.path, widths)
    if (result := _try_shortcuts(problem, curve, widths)) is not None:
        return result
    motion = _smooth_motion(problem, curve, widths)
    while (narrower := _narrow_corners(motion)) is not None:
        motion = _smooth_motion(problem, round_corners(problem.path, narrower), narrower)
    if motion.widths is not widths and motion.proof.whole:
        result = _try_shortcuts(problem, motion.curve, motion.widths)
    return result or (motion, 0)


def _try_shortcuts(problem: _Problem, curve: Curve, widths: Floats) -> tuple[_Motion, int] | None:
    """Return the motion along a curve with shortcuts, and their number; None if no faster one is proven."""
    if problem.most is None:
        return None
    shorter, phases, count, before = shorten(
        curve, problem.prover, problem.used, problem.floor, problem.cost, problem.most
    )
    if not count:
        return None
    motion = _smooth_motion(problem, shorter, widths, phases)
    takes = motion.trajectory.nanoseconds[-1]
    at_least = duration_of(before) / NANOSECOND  # without the window of the mean
    if takes >= at_least and takes >= _smooth_motion(problem, curve, widths, before).trajectory.nanoseconds[-1]:
        return None
    return (motion, count) if motion.proof.whole else None


def _find_provable_widths(problem: _Problem) -> Floats:
    """Return the widest of 1, 1/2, ... 1/64 of the allowed widths (k - 2,) with a proven parabola, else 0."""
    widths = problem.widest.copy()
    # the path itself is below the floor next to such a waypoint: it leads up from the start or down to the goal
    above = manipulability(problem.prover.robot, problem.path[:, : problem.dof]) >= problem.floor
    levels = np.where(above[:-2] & above[1:-1] & above[2:], problem.floor, 0.0)
    open_ = np.arange(len(widths))
    while len(open_):
        lifted = corner_parabolas(problem.path, widths)[open_]
        curves = lifted[..., : problem.dof]
        good = problem.prover.prove_curves(curves, contacts=False).free
        near = np.flatnonzero(good)
        good[near] &= problem.is_inside(curves[near], lifted[near, 0, -1], lifted[near, :, -1].sum(axis=1))
        if problem.floor > 0:
            asks = np.flatnonzero(good & (levels[open_] > 0))
            good[asks] = prove_floor(problem.prover.robot, curves[asks], levels[open_[asks]]).holds
        open_ = open_[~good]
        widths[open_] *= 0.5
        open_ = open_[widths[open_] >= _NARROWEST * problem.widest[open_]]
    return np.where(widths >= _NARROWEST * problem.widest, widths, 0.0)


def _smooth_motion(problem: _Problem, curve: Curve, widths: Floats, phases: Floats | None = None) -> _Motion:
    """Return the smoothed motion along a curve, slowed down until it keeps the limits exactly.

    ``phases`` are the curve's fastest phases, if they are known.
    """
    limits = problem.used
    spacing = knot_spacing(limits, problem.path[:, : problem.dof])
    if len(problem.path) == 1:
        q = problem.path[[0, 0]]
        still = Trajectory(problem.limits.joints, np.array([0, spacing[0]]), (q, 0.0 * q, 0.0 * q))
        trajectory, guide_places = _drop_guide_column(still, problem.dof)
        return _Motion(problem, curve, widths, trajectory, np.zeros(1, dtype=np.int64), guide_places)
    if phases is None:
        velocity, acceleration = limits.velocity, limits.acceleration
        if problem.guide is not None:
            velocity, acceleration = np.append(velocity, problem.guide.fastest), np.append(acceleration, _FREELY)
        phases = fastest_phases(curve, velocity, acceleration)
    stretch = 1.0
    while True:
        lifted, piece = average_motion(curve, phases, stretch, spacing, problem.limits.joints)
        trajectory, guide_places = _drop_guide_column(lifted, problem.dof)
        shares = motion_shares(trajectory.nanoseconds, *trajectory.columns, limits.rows).tolist()
        needed = max(share ** (1.0 / order) for order, share in enumerate(shares, start=1))
        if needed <= 1.0:
            return _Motion(problem, curve, widths, trajectory, piece, guide_places)
        stretch *= needed * (1.0 + _EXTRA)


def _drop_guide_column(lifted: Trajectory, dof: int) -> tuple[Trajectory, Floats]:
    """Return the motion of the joints, and the values (k, 0 or 1) of ``along`` at its knots."""
    guide_places = lifted.columns[0][:, dof:]
    if not guide_places.size:
        return lifted, guide_places
    return replace(lifted, columns=tuple(np.ascontiguousarray(rows[:, :dof]) for rows in lifted.columns)), guide_places


def _narrow_corners(motion: _Motion) -> Floats | None:
    """Return half the width for corners that are unproven or too far from the motion; None without such."""
    bad = np.flatnonzero((motion.proof.verdict != 0) | ~motion.proof.floor_holds | ~motion.is_inside)
    pieces, corner = motion.piece[bad], motion.curve.corner
    near = np.unique(np.concatenate([pieces, pieces - 1, pieces + 1]).clip(0, len(corner) - 1))
    corners = corner[near]
    corners = np.append(corners[corners > 0] - 1, _find_distant_corners(motion))
    if not len(corners):
        return None
    narrower = motion.widths.copy()
    narrower[corners] *= 0.5
    return np.where(narrower >= _NARROWEST * motion.problem.widest, narrower, 0.0)


def _find_distant_corners(motion: _Motion) -> Ints:
    """Return the rounded corners (m,) that the smoothed motion passes farther away than the deviation."""
    problem, rounded = motion.problem, np.flatnonzero(motion.curve.corner > 0)
    if not len(rounded) or np.isinf(problem.deviation):
        return np.zeros(0, dtype=np.int64)
    trajectory, corner = motion.trajectory, motion.curve.corner[rounded]
    first, behind = (np.searchsorted(motion.piece, rounded, side=side) for side in ("left", "right"))
    window, _ = knot_spacing(problem.used, problem.path[:, : problem.dof])
    clock = np.linspace(trajectory.nanoseconds[first], trajectory.nanoseconds[behind] + window, _SAMPLES) * NANOSECOND
    q = trajectory.at(clock.ravel()).reshape(_SAMPLES, len(corner), -1)
    off = np.abs(q - problem.path[corner, : problem.dof]).max(axis=2).min(axis=0)
    return corner[off > problem.deviation] - 1
