"""A motion in time: polynomial pieces between knots, as a joint trajectory controller interpolates its points."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from planner.base.arrays import Floats, Ints, frozen, numbers
from planner.base.errors import ArrayError
from planner.base.polynomials import bernstein, derivative, evaluate, extrema
from planner.motion.limits import LimitError, MotionLimits

if TYPE_CHECKING:
    from planner.motion.stopping import Stop

Interpolation = Literal["lines", "cubics", "quintics"]
_NOISE = 1e-12  # rad/s, rad/s²: what rounding makes of nothing
DEGREE: dict[Interpolation, int] = {"lines": 1, "cubics": 3, "quintics": 5}


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joint positions as polynomials of time: piece i runs from ``times[i]`` to ``times[i + 1]``.

    ``coefficients`` (k, degree + 1, dof) are those of u = (t - times[i]) / (times[i + 1] - times[i]) in [0, 1],
    ascending powers; ``times`` (k + 1,) s increase strictly. ``law`` says how the times came about, ``limits`` what
    they were made for, ``proven`` whether all of it is proven, and ``proof`` what. Make one with :meth:`through`.
    """

    joints: tuple[str, ...]
    times: Floats
    coefficients: Floats
    law: str = "given"
    limits: MotionLimits | None = None
    proven: bool = False
    proof: dict[str, Any] = field(default_factory=dict)

    @staticmethod
    def through(
        joints: tuple[str, ...],
        times: Floats,
        q: Floats,
        qd: Floats | None = None,
        qdd: Floats | None = None,
        *,
        law: str = "given",
    ) -> Trajectory:
        """The trajectory that a ROS 2 joint trajectory controller runs through points (k, dof) at ``times`` (k,).

        Lines between positions only, cubics where velocities ``qd`` are given, quintics with accelerations ``qdd``.
        Raises :class:`ArrayError` for other shapes, what is no finite number, and times that do not increase.
        """
        times, q, qd, qdd = _points(joints, times, q, qd, qdd)
        h = np.diff(times)[:, None]
        if qd is None:
            pieces = [q[:-1], np.diff(q, axis=0)]
        elif qdd is None:
            pieces = _cubics(q, qd[:-1] * h, qd[1:] * h)
        else:
            pieces = _quintics(q, qd[:-1] * h, qd[1:] * h, qdd[:-1] * h**2, qdd[1:] * h**2)
        return Trajectory(tuple(joints), frozen(times), frozen(np.stack(pieces, axis=1)), law)

    @property
    def duration(self) -> float:
        """Seconds from the first knot to the last."""
        return float(self.times[-1] - self.times[0])

    @property
    def interpolation(self) -> Interpolation:
        """What the pieces are."""
        return next(name for name, degree in DEGREE.items() if degree + 1 == self.coefficients.shape[1])

    def at(self, t: Floats | float, order: int = 0) -> Floats:
        """Positions (n, dof) at ``t`` (n,) s, or their derivative of an ``order``; at a knot those of the next piece.

        Before the first and after the last knot the robot stands where it is there.
        """
        if order < 0:
            raise ArrayError(f"there is no derivative of order {order}: give 0 for positions, 1 for velocities.")
        t = np.clip(numbers("t", np.atleast_1d(t), ("n",)), self.times[0], self.times[-1])
        piece = self.piece_at(t)
        h = np.diff(self.times)[piece]
        slope = derivative(self.coefficients[piece], order)
        return evaluate(slope, (t - self.times[piece]) / h) / h[:, None] ** order

    def piece_at(self, t: Floats) -> Ints:
        """The piece (n,) that each time (n,) lies on; at a knot the next one."""
        return np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.times) - 2)

    def knots(self, order: int = 0) -> Floats:
        """Positions (k + 1, dof) at the knots, or their derivative; where it jumps, the mean of both sides.

        A velocity or acceleration that is 0 but for rounding is 0.
        """
        before, after = self.ends(order)
        values = np.concatenate([after[:1], 0.5 * (before[:-1] + after[1:]), before[-1:]])
        return np.where(np.abs(values) < _NOISE, 0.0, values) if order else values

    def ends(self, order: int = 0) -> tuple[Floats, Floats]:
        """A derivative at the end and at the beginning of every piece (k, dof) each."""
        slope, h = derivative(self.coefficients, order), np.diff(self.times)[:, None]
        return slope.sum(axis=1) / h**order, slope[:, 0] / h**order

    def stop_at(self, t: float) -> Stop:
        """Braking from ``t`` s on along the same curve, within the limits that the trajectory was made for.

        Raises :class:`LimitError` where it was made for none: see :func:`planner.motion.stopping.stop_at`.
        """
        from planner.motion.stopping import stop_at

        if self.limits is None:
            raise LimitError(
                "the trajectory says no limits to brake within: give them to planner.motion.stopping.stop_at."
            )
        return stop_at(self, t, self.limits)

    def extrema(self, order: int = 0) -> tuple[Floats, Floats]:
        """The least and largest value (k, dof) of a derivative on every piece, exact but for rounding."""
        h = np.diff(self.times)[:, None] ** order
        low, high = extrema(derivative(self.coefficients, order))
        return low / h, high / h

    def largest(self, order: int) -> Floats:
        """The largest absolute value (k, dof) of a derivative on every piece."""
        return np.max(np.abs(self.extrema(order)), axis=0)

    def worst(self, order: int, most: Floats, beyond: float = 0.0) -> tuple[float, int, int]:
        """The largest share of a limit ``most`` (dof,) on a derivative, and the piece and joint that has it.

        Exact as :meth:`largest`, in a fraction of the time: only pieces are solved whose Bernstein coefficients are
        beyond the largest value at a knot. Shares up to ``beyond`` may come out smaller than they are.
        """
        h = np.diff(self.times)[:, None] ** order
        slope = derivative(self.coefficients, order)
        hull = np.abs(bernstein(slope))
        reached = np.maximum(hull[:, 0], hull[:, -1]) / h / most
        open_ = np.flatnonzero((hull.max(axis=1) / h / most).max(axis=1) > max(reached.max(), beyond))
        reached[open_] = np.max(np.abs(extrema(slope[open_])), axis=0) / h[open_] / most
        piece, joint = np.unravel_index(int(reached.argmax()), reached.shape)
        return float(reached[piece, joint]), int(piece), int(joint)


def _points(joints: tuple[str, ...], times: Floats, *columns: Floats | None) -> tuple[Any, ...]:
    """Times (k,) and columns (k, dof) as numbers; ArrayError where they are none, or no motion of the joints."""
    times = numbers("times", times, ("k",))
    if len(times) < 2 or not (np.diff(times) > 0).all():
        raise ArrayError("times have to increase strictly, and to be two at least: give seconds that do.")
    if columns[1] is None and columns[2] is not None:
        raise ArrayError("accelerations qdd say nothing without velocities: give qd too.")
    shape = len(times), len(joints) or "dof"  # parts of a motion have no names
    given = zip(("q", "qd", "qdd"), columns, strict=True)
    return times, *(None if column is None and name != "q" else numbers(name, column, shape) for name, column in given)


def _cubics(q: Floats, start: Floats, end: Floats) -> list[Floats]:
    """Hermite's cubics through positions with slopes by u at both ends of every piece."""
    delta = np.diff(q, axis=0)
    return [q[:-1], start, 3.0 * delta - 2.0 * start - end, start + end - 2.0 * delta]


def _quintics(q: Floats, start: Floats, end: Floats, bend: Floats, bent: Floats) -> list[Floats]:
    """Hermite's quintics: positions, slopes and second derivatives by u at both ends of every piece."""
    rest = np.diff(q, axis=0) - start - 0.5 * bend
    slope, curve = end - start - bend, bent - bend
    return [
        q[:-1],
        start,
        0.5 * bend,
        10.0 * rest - 4.0 * slope + 0.5 * curve,
        -15.0 * rest + 7.0 * slope - curve,
        6.0 * rest - 3.0 * slope + 0.5 * curve,
    ]
