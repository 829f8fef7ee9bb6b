"""A motion in time: polynomial pieces between knots, as a joint trajectory controller runs them."""

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
_NOISE = 1e-12  # rad/s, rad/s²: rounding error of a derivative that is 0
_LONGEST = 9e9  # s: the range of an int64 in nanoseconds
_LARGEST = 1e6  # rad, rad/s, rad/s², s: beyond any motion of an arm; polynomials of larger numbers become NaN
DEGREE: dict[Interpolation, int] = {"lines": 1, "cubics": 3, "quintics": 5}


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of a motion of ``joints`` at ``times`` (n,) s: positions (n, dof) rad or m, and derivatives."""

    joints: tuple[str, ...]
    times: Floats
    positions: Floats
    velocities: Floats
    accelerations: Floats
    jerks: Floats

    def to_pandas(self) -> Any:
        """Return a ``pandas.DataFrame`` with ``time`` and, per joint, ``q_NAME``, ``qd_NAME`` and so on.

            motion.sample(0.01).to_pandas().set_index("time")

        Accelerations are ``qdd_NAME``, jerks ``qddd_NAME``. Raises :class:`InstallationError` without pandas (extra
        ``interop``).
        """
        columns = {"q": self.positions, "qd": self.velocities, "qdd": self.accelerations, "qddd": self.jerks}
        by_name = {f"{kind}_{name}": rows[:, k] for kind, rows in columns.items() for k, name in enumerate(self.joints)}
        return require_extra("pandas", "interop").DataFrame({"time": self.times} | by_name)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joint positions as polynomials of time between points at whole ``nanoseconds`` (k + 1,).

    ``columns`` are positions (k + 1, dof) at the points, optionally velocities and accelerations: lines, cubics or
    quintics interpolate them, as in a ROS 2 joint trajectory controller. An export holds these points exactly. Derived
    from them: ``times`` (k + 1,) s, ``seconds`` (k,) of each piece, and ``coefficients``.

    ``time_law`` names the method that set the times, ``limits`` are those that it kept, ``proven`` says whether every
    proof of the motion succeeded, and ``proof`` holds the details. ``events`` happen during the motion, each at its
    time ``t`` (s), as in ``trajectory.json``; ``notes`` are about other content of a foreign file. :meth:`from_points`
    makes a trajectory of times in seconds.
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
                f"times must increase by a nanosecond or more, got point {late[0] + 2} too early: give later times."
            )
        # a difference of integers has no rounding error
        seconds = np.diff(clock) / 1e9
        fields = {"nanoseconds": clock, "columns": columns, "times": frozen(clock / 1e9), "seconds": frozen(seconds)}
        for name, value in fields.items():
            object.__setattr__(self, name, value)

    @cached_property
    def coefficients(self) -> Floats:
        """The pieces (k, degree + 1, dof) as polynomials of u in [0, 1], ascending powers."""
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
        """Return the trajectory through points (k, dof) at ``times`` (k,) s, to the nanosecond.

        Positions alone make lines, velocities ``qd`` cubics, accelerations ``qdd`` quintics. Raises :class:`ArrayError`
        for wrong shapes, numbers that are not finite, and times that do not increase, and :class:`LimitError` for two
        times within a nanosecond.
        """
        times = numbers("times", times, ("k",))
        if len(times) < 2 or not (np.diff(times) > 0).all():
            raise ArrayError(f"times must be two or more that increase, got {len(times)}: give seconds that do.")
        if qd is None and qdd is not None:
            raise ArrayError("qdd must come with velocities, got none: give qd too.")
        if len(set(joints)) < len(joints):
            raise ArrayError(f"joints must differ, got {choices(joints)}: name each once.")
        shape = len(times), len(joints) or "dof"  # partial motions have no joint names
        rows = {"q": q} | {name: values for name, values in (("qd", qd), ("qdd", qdd)) if values is not None}
        columns = tuple(numbers(name, values, shape) for name, values in rows.items())
        return Trajectory(tuple(joints), to_nanoseconds(times), columns, time_law)

    @staticmethod
    def load(path: StrPath) -> Trajectory:
        """Return the trajectory of a ``trajectory.json``, or of its folder, with its limits and its proof.

            Trajectory.load("out").duration

        Raises :class:`FileError` for a missing or damaged file, and for times that do not increase.
        """
        path = Path(path)
        path = path / TRAJECTORY_NAME if os.path.isdir(path) else path
        if not os.path.isfile(path):
            raise FileError(f"trajectory {path} not found: check the path, or plan a motion first.")
        where = f"trajectory {path}"
        return trajectory_from_file(
            validate(TrajectoryFile, parse_json(read_text(path, "trajectory"), where), where), where
        )

    def save(self, path: StrPath, robot: str | None = None, scene: str | None = None) -> None:
        """Write ``trajectory.json`` atomically; raises :class:`FileError` if that fails."""
        write_json(Path(path), self.to_dict(robot, scene))

    def to_dict(self, robot: str | None = None, scene: str | None = None) -> dict[str, Any]:
        """Return the trajectory as plain data with the keys of ``trajectory.json``; s, rad, m.

        ``interpolation`` names the polynomials between points: cubics take positions and velocities, quintics
        accelerations as well.
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
        """The kind of the pieces."""
        return next(name for name, degree in DEGREE.items() if degree + 1 == self.coefficients.shape[1])

    def at(self, t: Floats | float, order: int = 0) -> Floats:
        """Return positions (n, dof) at ``t`` (n,) s, or a derivative; at a knot those of the next piece.

        The robot rests at the first and the last knot before and after the motion.
        """
        t = np.clip(numbers("t", np.atleast_1d(t), ("n",)), self.times[0], self.times[-1])
        piece = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.seconds) - 1)
        return self.on(piece, t - self.times[piece], order)

    def sample(self, dt: float) -> Samples:
        """Return the motion every ``dt`` s and at its end, with its first three derivatives.

            motion.sample(0.01).velocities  # (n, dof) rad/s

        At a knot they are those of the next piece. Raises :class:`ArrayError` unless ``dt`` is above 0.
        """
        if not 0 < dt < np.inf:
            raise ArrayError(f"dt must be above 0 s, got {dt:g}: give the time from one sample to the next.")
        count = max(1, int(np.ceil(self.duration / dt - 1e-9)))  # avoids a sample a rounding error before the end
        times = frozen(np.append(self.times[0] + dt * np.arange(count), self.times[-1]))
        return Samples(self.joints, times, *(frozen(self.at(times, order)) for order in range(4)))

    def at_nanoseconds(self, clock: Any, order: int = 0) -> Floats:
        """Return positions as :meth:`at` does, at nanoseconds (n,); whole ones have no rounding error."""
        clock = np.clip(clock, self.nanoseconds[0], self.nanoseconds[-1])
        piece = self.piece_at(clock)
        return self.on(piece, (clock - self.nanoseconds[piece]) / 1e9, order)

    def on(self, piece: Ints, since: Floats, order: int = 0) -> Floats:
        """Return positions (n, dof), or a derivative, on pieces (n,) at ``since`` (n,) s after their start."""
        h, order = self.seconds[piece], self._order(order)
        slope = derivative(self.coefficients[piece], order)
        return evaluate(slope, since / h) / powers(h, order)[:, -1:]

    def _order(self, order: int) -> int:
        """Return the order, at most degree + 1: the first derivative that is 0 stands for all later ones."""
        if order < 0:
            raise ArrayError(f"order must be 0 or more, got {order}: give 0 for positions, 1 for velocities.")
        return min(order, self.coefficients.shape[1])

    def piece_at(self, clock: Ints | Floats) -> Ints:
        """Return the piece (n,) of each moment (n,) ns; at a knot the next one."""
        return np.clip(np.searchsorted(self.nanoseconds, clock, side="right") - 1, 0, len(self.seconds) - 1)

    def knots(self, order: int = 0) -> Floats:
        """Return positions (k + 1, dof) at the knots, or a derivative: the stored values, if there are any.

        Other derivatives may jump at a knot: these are the mean of both sides, and 0 within rounding.
        """
        if (order := self._order(order)) < len(self.columns):
            return self.columns[order]
        before, after = self.ends(order)
        values = np.concatenate([after[:1], 0.5 * (before[:-1] + after[1:]), before[-1:]])
        return np.where(np.abs(values) < _NOISE, 0.0, values)

    def ends(self, order: int = 0) -> tuple[Floats, Floats]:
        """Return a derivative at the end and at the start of every piece, (k, dof) each."""
        order = self._order(order)
        slope, h = derivative(self.coefficients, order), powers(self.seconds, order)[:, -1:]
        return slope.sum(axis=1) / h, slope[:, 0] / h

    def extrema(self, order: int = 0) -> tuple[Floats, Floats]:
        """Return the least and the largest value (k, dof) of a derivative per piece, exact within rounding."""
        order = self._order(order)
        h = powers(self.seconds, order)[:, -1:]
        low, high = polynomial_extrema(derivative(self.coefficients, order))
        return low / h, high / h

    def largest(self, order: int) -> Floats:
        """Return the largest absolute value (k, dof) of a derivative per piece."""
        return np.max(np.abs(self.extrema(order)), axis=0)

    def worst(self, order: int, most: Floats, beyond: float = 0.0) -> tuple[float, int, int]:
        """Return the largest share of a limit ``most`` (dof,) on a derivative, with its piece and joint.

        It is as exact as :meth:`largest` and much faster: it solves only pieces whose Bernstein coefficients exceed the
        largest value so far. Shares up to ``beyond`` may be underestimated.
        """
        return polynomial_worst(self.coefficients, self.seconds, order, most, beyond)


def trajectory_from_file(file: TrajectoryFile, where: str) -> Trajectory:
    """Return the trajectory of a file, its joints in the file's order."""
    events = tuple(event.model_dump() for event in file.events)
    try:
        json.dumps([file.joints, events], ensure_ascii=False, allow_nan=False).encode()
    except ValueError:  # half of a surrogate pair, NaN
        raise FileError(f"{where}: joints and events must be text and finite numbers; mend the file.") from None
    if len(set(file.joints)) < len(file.joints):
        raise FileError(f"{where}: joints must differ, got {choices(file.joints)}; mend the file.")
    columns = [[getattr(point, key) for point in file.points] for key in ("q", "qd", "qdd")]
    count = None if file.interpolation is None else (DEGREE[file.interpolation] + 1) // 2
    rows = require_columns(columns[:count], len(file.joints), where)
    if count not in (None, len(rows)):
        raise FileError(
            f"{where}: {file.interpolation} must have {count} of q, qd and qdd per point, got {len(rows)}; add them."
        )
    proof = file.proof.model_dump(exclude_unset=True)
    limits = read_limits(file.limits, tuple(file.joints), where)
    fields = {"time_law": file.law, "limits": limits, "proven": file.proven, "proof": proof, "events": events}
    return trajectory_from_points(
        tuple(file.joints), np.array([point.t for point in file.points]), rows, where, **fields
    )


def trajectory_from_points(
    joints: tuple[str, ...], times: Floats, columns: list[Floats], where: str, **fields: Any
) -> Trajectory:
    """Return the trajectory through a file's points; :class:`FileError` for impossible times and numbers."""
    for rows in (times[:, None], *columns):
        bad = np.argwhere(~(np.abs(rows) <= _LARGEST))
        if len(bad):
            raise FileError(
                f"{where}: numbers must be finite and at most {_LARGEST:g}, got others at point {bad[0, 0] + 1}; "
                "mend the file."
            )
    if len(times) < 2:
        raise FileError(f"{where}: points must be two or more, got one; add another.")
    try:
        return Trajectory(joints, np.round(times * 1e9).astype(np.int64), tuple(columns), **fields)
    except PlannerError as error:
        raise FileError(f"{where}: {error}") from None


def to_nanoseconds(times: Floats) -> Ints:
    """Return times (k,) s as whole nanoseconds; the conversion is reversible up to 26 days.

    Raises :class:`LimitError` for times beyond the range of an int64.
    """
    bad = np.flatnonzero(~(np.abs(times) <= _LONGEST))
    if len(bad):
        at = f"times must be at most {_LONGEST:g} s, got {times[bad[0]]:g} s at point {bad[0] + 1}"
        raise LimitError(f"{at}: give smaller ones.")
    return np.round(np.asarray(times, dtype=np.float64) * 1e9).astype(np.int64)


def interpolate(h: Floats, q: Floats, qd: Floats | None = None, qdd: Floats | None = None) -> Floats:
    """Return coefficients (k, degree + 1, dof) of pieces that take ``h`` (k, 1) s through given ends.

    A ROS 2 joint trajectory controller does the same: lines between positions (k + 1, dof), cubics with velocities,
    quintics with accelerations.
    """
    if qd is None:
        powers_of_u = [q[:-1], np.diff(q, axis=0)]
    elif qdd is None:
        powers_of_u = _cubics(q, qd[:-1] * h, qd[1:] * h)
    else:
        powers_of_u = _quintics(q, qd[:-1] * h, qd[1:] * h, qdd[:-1] * h**2, qdd[1:] * h**2)
    return np.stack(powers_of_u, axis=1)


def _cubics(q: Floats, start: Floats, end: Floats) -> list[Floats]:
    """Return Hermite cubics through positions with slopes by u at both ends of every piece."""
    delta = np.diff(q, axis=0)
    return [q[:-1], start, 3.0 * delta - 2.0 * start - end, start + end - 2.0 * delta]


def _quintics(q: Floats, start: Floats, end: Floats, bend: Floats, bent: Floats) -> list[Floats]:
    """Return Hermite quintics through positions, slopes and second derivatives by u at both ends."""
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
