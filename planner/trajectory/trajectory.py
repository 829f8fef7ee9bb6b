"""A motion in time: polynomial pieces between knots, as a joint trajectory controller interpolates its points."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints, frozen, numbers
from planner.base.errors import ArrayError, FileError, PlannerError, choices, require_extra
from planner.base.files import StrPath, write_json
from planner.base.polynomials import derivative, evaluate, powers
from planner.base.yamlfile import read_text, validate
from planner.native.compiled import polynomial_extrema, polynomial_worst
from planner.trajectory.file import (
    TRAJECTORY_NAME,
    Interpolation,
    TrajectoryFile,
    parse_json,
    read_limits,
    require_columns,
)
from planner.trajectory.limits import LimitError, MotionLimits

NANOSECOND = 1e-9  # s
_NOISE = 1e-12  # rad/s, rad/s²: what rounding makes of nothing
_LONGEST = 9e9  # s: an int64 holds as many in nanoseconds
_LARGEST = 1e6  # rad, rad/s, rad/s², s: no motion of an arm goes there, and of such numbers polynomials become NaN
DEGREE: dict[Interpolation, int] = {"lines": 1, "cubics": 3, "quintics": 5}


@dataclass(frozen=True, eq=False)
class Samples:
    """A motion of ``joints`` at ``times`` (n,) s: positions (n, dof) rad (m where a joint slides), and derivatives."""

    joints: tuple[str, ...]
    times: Floats
    positions: Floats
    velocities: Floats
    accelerations: Floats
    jerks: Floats

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame``: ``time``, then of each joint ``q_NAME``, ``qd_NAME``, ``qdd_NAME``, ``qddd_NAME``.

            motion.sample(0.01).to_pandas().set_index("time")

        Raises :class:`InstallationError` without pandas, which the extra ``interop`` brings.
        """
        columns = {"q": self.positions, "qd": self.velocities, "qdd": self.accelerations, "qddd": self.jerks}
        by_name = {f"{kind}_{name}": rows[:, k] for kind, rows in columns.items() for k, name in enumerate(self.joints)}
        return require_extra("pandas", "interop").DataFrame({"time": self.times} | by_name)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joint positions as polynomials of time between points at whole ``nanoseconds`` (k + 1,), strictly increasing.

    ``columns`` are positions (k + 1, dof) at the points, perhaps velocities and accelerations: lines, cubics or
    quintics run through them, as in a ROS 2 joint trajectory controller. The points are all that there is, to the last
    bit what an export holds; all else follows: ``times`` (k + 1,) s, ``seconds`` (k,) that piece i takes from
    ``times[i]`` to ``times[i + 1]``, and ``coefficients``.

    ``time_law`` says how the times came about, ``limits`` what they were made for, ``proven`` whether all of it is
    proven, and ``proof`` what. ``events`` are what happens meanwhile, each with its time ``t`` (s), as
    ``trajectory.json`` has them; ``notes`` are on what a foreign file holds besides. Of times in seconds make one with
    :meth:`from_points`.
    """

    joints: tuple[str, ...]
    nanoseconds: Ints
    columns: tuple[Floats, ...]
    time_law: str = "given"
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
        return frozen(interpolate(self.seconds[:, None], *self.columns))

    def __repr__(self) -> str:
        size = f"{len(self.joints)} joints, {len(self.times)} points, {self.duration:.3f} s"
        return f"<Trajectory: {size}, {'proven' if self.proven else 'not proven'}>"

    @staticmethod
    def from_points(
        joints: tuple[str, ...],
        times: Floats,
        q: Floats,
        qd: Floats | None = None,
        qdd: Floats | None = None,
        *,
        time_law: str = "given",
    ) -> Trajectory:
        """The trajectory through points (k, dof) at ``times`` (k,) s, to the nanosecond.

        Lines between positions only, cubics where velocities ``qd`` are given, quintics with accelerations too.
        Raises :class:`ArrayError` for other shapes, what is no finite number, and times that do not increase, and
        :class:`LimitError` where two times are the same to the nanosecond.
        """
        times = numbers("times", times, ("k",))
        if len(times) < 2 or not (np.diff(times) > 0).all():
            raise ArrayError("times have to increase strictly, and to be two at least: give seconds that do.")
        if qd is None and qdd is not None:
            raise ArrayError("accelerations qdd say nothing without velocities: give qd too.")
        if len(set(joints)) < len(joints):
            raise ArrayError(f"joints {choices(joints)} are not usable: name each once.")
        shape = len(times), len(joints) or "dof"  # parts of a motion have no names
        given = {"q": q} | {name: rows for name, rows in (("qd", qd), ("qdd", qdd)) if rows is not None}
        columns = tuple(numbers(name, rows, shape) for name, rows in given.items())
        return Trajectory(tuple(joints), to_nanoseconds(times), columns, time_law)

    @staticmethod
    def load(path: StrPath) -> Trajectory:
        """The trajectory of a ``trajectory.json``, or of the folder that holds one, with its limits and its proof.

            Trajectory.load("out").duration

        Raises :class:`FileError` for a file that is none, is damaged, or whose times do not increase.
        """
        path = Path(path)
        path = path / TRAJECTORY_NAME if os.path.isdir(path) else path
        if not os.path.isfile(path):
            raise FileError(f"trajectory {path} not found: plan first, with times, or check the path.")
        where = f"trajectory {path}"
        return trajectory_from_file(
            validate(TrajectoryFile, parse_json(read_text(path, "trajectory"), where), where), where
        )

    def save(self, path: StrPath, robot: str | None = None, scene: str | None = None) -> None:
        """Write ``trajectory.json`` whole or not at all; raises :class:`FileError` where that cannot be done."""
        write_json(Path(path), self.to_dict(robot, scene))

    def to_dict(self, robot: str | None = None, scene: str | None = None) -> dict[str, Any]:
        """The trajectory as plain data, the keys of ``trajectory.json``; s, rad, m.

        Between two points it is the polynomial that ``interpolation`` says: cubics take positions and velocities,
        quintics accelerations too.
        """
        columns = (self.times.tolist(), *(self.knots(order).tolist() for order in range(3)))
        return {
            "robot": robot,
            "scene": scene,
            "law": self.time_law,
            "duration": self.duration,
            "limits": self.limits.to_dict() if self.limits else None,
            "interpolation": self.interpolation,
            "joints": list(self.joints),
            "proven": self.proven,
            "proof": self.proof,
            **({"events": [dict(event) for event in self.events]} if self.events else {}),
            "points": [{"t": t, "q": q, "qd": qd, "qdd": qdd} for t, q, qd, qdd in zip(*columns, strict=True)],
        }

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

    def sample(self, dt: float) -> Samples:
        """The motion every ``dt`` s from its beginning on, and at its end, with its first three derivatives.

            motion.sample(0.01).velocities  # (n, dof) rad/s

        At a knot they are those of the next piece. Raises :class:`ArrayError` unless ``dt`` is above 0.
        """
        if not 0 < dt < np.inf:
            raise ArrayError(f"dt must be above 0 s, got {dt:g}: give the time from one sample to the next.")
        count = max(1, int(np.ceil(self.duration / dt - 1e-9)))  # no sample a rounding before the end
        times = frozen(np.append(self.times[0] + dt * np.arange(count), self.times[-1]))
        return Samples(self.joints, times, *(frozen(self.at(times, order)) for order in range(4)))

    def at_nanoseconds(self, clock: Any, order: int = 0) -> Floats:
        """As :meth:`at`, at nanoseconds (n,): where they are whole, nothing of the time since a knot is rounded off."""
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

    def piece_at(self, clock: Ints | Floats) -> Ints:
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


def trajectory_from_file(file: TrajectoryFile, where: str) -> Trajectory:
    """The trajectory that a file holds, its joints in the order of the file."""
    events = tuple(event.model_dump() for event in file.events)
    try:
        json.dumps([file.joints, events], ensure_ascii=False, allow_nan=False).encode()
    except ValueError:  # half of a surrogate pair, NaN
        raise FileError(f"{where}: its joints or events hold what is no text or no number; mend the file.") from None
    if len(set(file.joints)) < len(file.joints):
        raise FileError(f"{where} names a joint twice; it names {choices(file.joints)}: mend the file.")
    columns = [[getattr(point, key) for point in file.points] for key in ("q", "qd", "qdd")]
    given = None if file.interpolation is None else (DEGREE[file.interpolation] + 1) // 2
    rows = require_columns(columns[:given], len(file.joints), where)
    if given not in (None, len(rows)):
        raise FileError(f"{where}: {file.interpolation} need {given} of q, qd and qdd at each point; add them.")
    proof = file.proof.model_dump(exclude_unset=True)
    limits = read_limits(file.limits, tuple(file.joints), where)
    told = {"time_law": file.law, "limits": limits, "proven": file.proven, "proof": proof, "events": events}
    return trajectory_from_points(tuple(file.joints), np.array([point.t for point in file.points]), rows, where, **told)


def trajectory_from_points(
    joints: tuple[str, ...], times: Floats, columns: list[Floats], where: str, **told: Any
) -> Trajectory:
    """The trajectory through the points of a file; :class:`FileError` for times and numbers that no motion has."""
    for rows in (times[:, None], *columns):
        bad = np.argwhere(~(np.abs(rows) <= _LARGEST))
        if len(bad):
            raise FileError(
                f"{where}: point {bad[0, 0] + 1} holds a number that is not finite or absurd; mend the file."
            )
    if len(times) < 2:
        raise FileError(f"{where} holds one point: a trajectory has two or more.")
    try:
        return Trajectory(joints, np.round(times * 1e9).astype(np.int64), tuple(columns), **told)
    except PlannerError as error:
        raise FileError(f"{where}: {error}") from None


def to_nanoseconds(times: Floats) -> Ints:
    """Times (k,) s as whole nanoseconds; those that they are made of come back, up to 26 days.

    Raises :class:`LimitError` for times that no clock of nanoseconds holds.
    """
    bad = np.flatnonzero(~(np.abs(times) <= _LONGEST))
    if len(bad):
        at = f"point {bad[0] + 1} of the trajectory is at {times[bad[0]]:g} s"
        raise LimitError(f"{at}: give times below {_LONGEST:g} s.")
    return np.round(np.asarray(times, dtype=np.float64) * 1e9).astype(np.int64)


def interpolate(h: Floats, q: Floats, qd: Floats | None = None, qdd: Floats | None = None) -> Floats:
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
