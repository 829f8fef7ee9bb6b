"""A motion in time: polynomial pieces between knots, as a joint trajectory controller interpolates its points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np

from planner.base.arrays import Floats, Ints, frozen, numbers
from planner.base.errors import ArrayError, choices
from planner.base.polynomials import derivative, evaluate, powers
from planner.native.compiled import polynomial_extrema, polynomial_worst
from planner.trajectory.limits import LimitError, MotionLimits

NANOSECOND = 1e-9  # s
Interpolation = Literal["lines", "cubics", "quintics"]
_NOISE = 1e-12  # rad/s, rad/s²: what rounding makes of nothing
_LONGEST = 9e9  # s: an int64 holds as many in nanoseconds
DEGREE: dict[Interpolation, int] = {"lines": 1, "cubics": 3, "quintics": 5}


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joint positions as polynomials of time between points at whole ``nanoseconds`` (k + 1,), strictly increasing.

    ``columns`` are positions (k + 1, dof) at the points, perhaps velocities and accelerations: lines, cubics or
    quintics run through them, as in a ROS 2 joint trajectory controller. The points are all that there is, to the last
    bit what an export holds; all else follows: ``times`` (k + 1,) s, ``seconds`` (k,) that piece i takes from
    ``times[i]`` to ``times[i + 1]``, and ``coefficients``.

    ``law`` says how the times came about, ``limits`` what they were made for, ``proven`` whether all of it is proven,
    and ``proof`` what. ``events`` are what happens meanwhile, each with its time ``t`` (s), as ``trajectory.json`` has
    them; ``notes`` are on what a foreign file holds besides. Of times in seconds make one with :meth:`through`.
    """

    joints: tuple[str, ...]
    nanoseconds: Ints
    columns: tuple[Floats, ...]
    law: str = "given"
    limits: MotionLimits | None = None
    proven: bool = False
    proof: dict[str, Any] = field(default_factory=dict)
    events: tuple[Mapping[str, Any], ...] = ()
    notes: tuple[str, ...] = ()
    times: Floats = field(init=False)
    seconds: Floats = field(init=False)

    def __post_init__(self) -> None:
        clock, columns = frozen(self.nanoseconds, np.int64), tuple(map(frozen, self.columns))
        late = np.flatnonzero(np.diff(clock) <= 0)
        if len(late):
            raise LimitError(
                f"point {late[0] + 2} of the trajectory is not a nanosecond behind the one before it: "
                "give times that increase."
            )
        # a difference of integers has no rounding; one of seconds is rounded by what the clock shows
        seconds = np.diff(clock) / 1e9
        made = {"nanoseconds": clock, "columns": columns, "times": frozen(clock / 1e9), "seconds": frozen(seconds)}
        for name, value in made.items():
            object.__setattr__(self, name, value)

    @cached_property
    def coefficients(self) -> Floats:
        """The pieces (k, degree + 1, dof) of u in [0, 1] along each, ascending powers."""
        return frozen(pieces_through(self.seconds[:, None], *self.columns))

    def __repr__(self) -> str:
        size = f"{len(self.joints)} joints, {len(self.times)} points, {self.duration:.3f} s"
        return f"<Trajectory: {size}, {'proven' if self.proven else 'not proven'}>"

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
        """The trajectory through points (k, dof) at ``times`` (k,) s, to the nanosecond.

        Lines between positions only, cubics where velocities ``qd`` are given, quintics with accelerations too.
        Raises :class:`ArrayError` for other shapes, what is no finite number, and times that do not increase, and
        :class:`LimitError` where two times are the same to the nanosecond.
        """
        times, q, qd, qdd = _points(joints, times, q, qd, qdd)
        given = (q,) if qd is None else (q, qd) if qdd is None else (q, qd, qdd)
        return Trajectory(tuple(joints), whole_nanoseconds(times), given, law)

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
        t = np.clip(numbers("t", np.atleast_1d(t), ("n",)), self.times[0], self.times[-1])
        piece = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.seconds) - 1)
        return self.on(piece, t - self.times[piece], order)

    def at_nanoseconds(self, clock: Ints, order: int = 0) -> Floats:
        """As :meth:`at`, at whole nanoseconds (n,): nothing of the time since a knot is lost to rounding."""
        clock = np.clip(clock, self.nanoseconds[0], self.nanoseconds[-1])
        piece = self.piece_at(clock)
        return self.on(piece, (clock - self.nanoseconds[piece]) / 1e9, order)

    def on(self, piece: Ints, since: Floats, order: int = 0) -> Floats:
        """Positions (n, dof) on pieces (n,), ``since`` (n,) s after their beginnings, or their derivative."""
        h, order = self.seconds[piece], self._order(order)
        slope = derivative(self.coefficients[piece], order)
        return evaluate(slope, since / h) / powers(h, order)[:, -1:]

    def _order(self, order: int) -> int:
        """An order of derivatives; all above the degree are 0, as that of the first of these is."""
        if order < 0:
            raise ArrayError(f"there is no derivative of order {order}: give 0 for positions, 1 for velocities.")
        return min(order, self.coefficients.shape[1])

    def piece_at(self, clock: Ints) -> Ints:
        """The piece (n,) that each moment (n,) ns lies on; at a knot the next one."""
        return np.clip(np.searchsorted(self.nanoseconds, clock, side="right") - 1, 0, len(self.seconds) - 1)

    def knots(self, order: int = 0) -> Floats:
        """Positions (k + 1, dof) at the knots, or their derivative: what is given there, to the last bit.

        What is not given may jump; then it is the mean of both sides, and 0 where it is 0 but for rounding.
        """
        if (order := self._order(order)) < len(self.columns):
            return self.columns[order]
        before, after = self.ends(order)
        values = np.concatenate([after[:1], 0.5 * (before[:-1] + after[1:]), before[-1:]])
        return np.where(np.abs(values) < _NOISE, 0.0, values)

    def ends(self, order: int = 0) -> tuple[Floats, Floats]:
        """A derivative at the end and at the beginning of every piece (k, dof) each."""
        order = self._order(order)
        slope, h = derivative(self.coefficients, order), powers(self.seconds, order)[:, -1:]
        return slope.sum(axis=1) / h, slope[:, 0] / h

    def extrema(self, order: int = 0) -> tuple[Floats, Floats]:
        """The least and largest value (k, dof) of a derivative on every piece, exact but for rounding."""
        order = self._order(order)
        h = powers(self.seconds, order)[:, -1:]
        low, high = polynomial_extrema(derivative(self.coefficients, order))
        return low / h, high / h

    def largest(self, order: int) -> Floats:
        """The largest absolute value (k, dof) of a derivative on every piece."""
        return np.max(np.abs(self.extrema(order)), axis=0)

    def worst(self, order: int, most: Floats, beyond: float = 0.0) -> tuple[float, int, int]:
        """The largest share of a limit ``most`` (dof,) on a derivative, and the piece and joint that has it.

        Exact as :meth:`largest`, in a fraction of the time: only pieces are solved whose Bernstein coefficients are
        beyond the largest value there is so far. Shares up to ``beyond`` may come out smaller than they are.
        """
        return polynomial_worst(self.coefficients, self.seconds, order, most, beyond)


def _points(joints: tuple[str, ...], times: Floats, *columns: Floats | None) -> tuple[Any, ...]:
    """Times (k,) and columns (k, dof) as numbers; ArrayError where they are none, or no motion of the joints."""
    times = numbers("times", times, ("k",))
    if len(times) < 2 or not (np.diff(times) > 0).all():
        raise ArrayError("times have to increase strictly, and to be two at least: give seconds that do.")
    if columns[1] is None and columns[2] is not None:
        raise ArrayError("accelerations qdd say nothing without velocities: give qd too.")
    if len(set(joints)) < len(joints):
        raise ArrayError(f"joints {choices(joints)} are not usable: name each once.")
    shape = len(times), len(joints) or "dof"  # parts of a motion have no names
    given = zip(("q", "qd", "qdd"), columns, strict=True)
    return times, *(None if column is None and name != "q" else numbers(name, column, shape) for name, column in given)


def whole_nanoseconds(times: Floats) -> Ints:
    """Times (k,) s as whole nanoseconds; those that they are made of come back, up to 26 days.

    Raises :class:`LimitError` for times that no clock of nanoseconds holds.
    """
    bad = np.flatnonzero(~(np.abs(times) <= _LONGEST))
    if len(bad):
        at = f"point {bad[0] + 1} of the trajectory is at {times[bad[0]]:g} s"
        raise LimitError(f"{at}: give times below {_LONGEST:g} s.")
    return np.round(np.asarray(times, dtype=np.float64) * 1e9).astype(np.int64)


def pieces_through(h: Floats, q: Floats, qd: Floats | None = None, qdd: Floats | None = None) -> Floats:
    """The coefficients (k, degree + 1, dof) of pieces that take ``h`` (k, 1) s, through what is given at their ends.

    As a ROS 2 joint trajectory controller has them: lines between positions (k + 1, dof), cubics with velocities,
    quintics with accelerations too.
    """
    if qd is None:
        found = [q[:-1], np.diff(q, axis=0)]
    elif qdd is None:
        found = _cubics(q, qd[:-1] * h, qd[1:] * h)
    else:
        found = _quintics(q, qd[:-1] * h, qd[1:] * h, qdd[:-1] * h**2, qdd[1:] * h**2)
    pieces = np.empty((len(h), len(found), q.shape[1]))
    for power, column in enumerate(found):
        pieces[:, power] = column
    return pieces


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
