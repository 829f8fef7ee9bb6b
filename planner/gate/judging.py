"""The judgement on a chunk: limits, a stop from every point, and one proof of all curves together.

At every point of the safe part its own stop is proven. Between two points the robot runs on along the proven piece to
the next one and stops there: so from any moment of the safe part on there is a proven motion to rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, Ints, frozen
from planner.base.errors import OptionError, choices
from planner.base.polynomials import bernstein, derivative
from planner.constraints.keeps import Keeps
from planner.gate.chunk import Chunk
from planner.gate.guard import Guard
from planner.gate.verdict import WHERE, Unsafe, Verdict
from planner.kinematics.manipulability_proof import prove_floor
from planner.models.robot import Robot
from planner.native.motions import chunk_curves, pieces_within, polynomial_extrema, stops_quickest
from planner.setup.resolve import beyond_limits, position_bounds
from planner.trajectory.clearance import nearest_on_pieces
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.proof import ROUNDING
from planner.trajectory.trajectory import Trajectory

RUNGS = frozen(np.round(2e7 * 1.2 ** np.arange(32)) / 1e9)  # s that a stop may take, to the nanosecond: up to 5.7
POSITION = "position"
JUDGED = (POSITION, *KINDS)
_JUDGED = {1: 1, 3: 2, 5: 3}  # kinds of limits, by the degree of the pieces: the next derivative jumps at the points
_LINES = "lines: their velocity jumps at the points, so acceleration and jerk are not judged; stops begin without any"
_CUBICS = "cubics: their acceleration jumps at the points, so the jerk is not judged; that of stops is"
_ROUGH = "the state has no acceleration: the first piece is a cubic, and the jerk is not judged where it ends"
_LED = "no state: what leads to the first point is not judged"
_NOTES = {1: (_LINES,), 3: (_CUBICS,), 5: ()}


@dataclass(frozen=True, slots=True, eq=False)
class Rules:
    """What is asked beside clearance: limits ``most`` (3, dof), infinite ones ask for nothing, and on positions.

    ``lower`` and ``upper`` (dof,) are those, infinite where they are not asked for.
    ``floor``: what manipulability keeps above, 0 for none; ``apart`` (rad, rad/s): of a point at 0 s from the state.
    """

    most: Floats
    lower: Floats
    upper: Floats
    floor: float
    apart: float

    @staticmethod
    def of(
        robot: Robot, limits: MotionLimits, judged: Sequence[str] = JUDGED, floor: float = 0.0, apart: float = 0.0
    ) -> Rules:
        """The rules that ask for those limits that are ``judged``; :class:`OptionError` for what makes no sense."""
        unknown = sorted({str(kind) for kind in judged} - set(JUDGED))
        if isinstance(judged, str) or unknown:
            raise OptionError(f"judged names {choices(unknown) or repr(judged)}: give a list out of {choices(JUDGED)}.")
        for name, value in (("min_manipulability", floor), ("start_tolerance", apart)):
            if not 0.0 <= value < np.inf:
                raise OptionError(f"{name} is {value:g}: give a number from 0 on.")
        none = np.full(len(limits.joints), np.inf)
        most = np.array([getattr(limits, kind) if kind in judged else none for kind in KINDS])
        lower, upper = position_bounds(robot) if POSITION in judged else (-none, none)
        return Rules(most, lower, upper, float(floor), float(apart))


@dataclass(frozen=True, slots=True, eq=False)
class _Bad:
    """The first bad piece, or the piece before the first bad stop, when (s), and why."""

    piece: int
    time: float
    why: Unsafe


def judge(guard: Guard, rules: Rules, chunk: Chunk, stop: bool) -> Verdict:
    """The verdict on a chunk, with or without stops."""
    judged = Judged(guard, rules, chunk)
    bad = judged.broken_limit()
    if (away := chunk.jump()).max() > rules.apart:
        joint = guard.checker.robot.joints[int(away.argmax())]
        bad = _Bad(0, float(chunk.times[0]), Unsafe("start", "start", joint=joint))
    bad = judged.unproven(stop, bad) or bad
    more = ((_ROUGH, chunk.rough), (_LED, chunk.times[0] > 0.0))
    notes = (*_NOTES[chunk.degree], *(note for note, holds in more if holds))
    if bad is None:
        return Verdict(True, float(chunk.times[-1]), None, None, notes, judged, len(chunk.seconds))
    return Verdict(False, float(chunk.times[bad.piece]), bad.why, bad.time, notes, judged, bad.piece)


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A chunk in the world, and by the rules, of its check."""

    guard: Guard
    rules: Rules
    chunk: Chunk

    def broken_limit(self) -> _Bad | None:
        """The first piece that is beyond a limit, by its exact extrema."""
        chunk, rules = self.chunk, self.rules
        most, between = rules.most[: _JUDGED[chunk.degree]] * (1.0 + ROUNDING), (rules.lower, rules.upper)
        if pieces_within(chunk.coefficients, chunk.seconds, most, between):
            return None
        found = [self._beyond_position(), *map(self._beyond, range(1, _JUDGED[self.chunk.degree] + 1))]
        return min((bad for bad in found if bad is not None), key=lambda bad: bad.piece, default=None)

    def _beyond(self, order: int) -> _Bad | None:
        chunk, most = self.chunk, self.rules.most[order - 1]
        limit = most * (1.0 + ROUNDING)
        slopes, unit = derivative(chunk.coefficients, order), chunk.seconds[:, None] ** order
        rows = np.flatnonzero((np.abs(bernstein(slopes)).max(axis=1) / unit > limit).any(axis=1))
        values = np.max(np.abs(polynomial_extrema(slopes[rows])), axis=0) / unit[rows]
        return self._first(rows, np.where(values > limit, values / most, 0.0), KINDS[order - 1])

    def _beyond_position(self) -> _Bad | None:
        robot, hull = self.guard.checker.robot, bernstein(self.chunk.coefficients)
        low, high = hull.min(axis=1), hull.max(axis=1)
        rows = np.flatnonzero(((low < self.rules.lower) | (high > self.rules.upper)).any(axis=1))
        if not len(rows):
            return None
        beyond = [beyond_limits(robot, values) for values in polynomial_extrema(self.chunk.coefficients[rows])]
        return self._first(rows, np.max(beyond, axis=0), POSITION)

    def _first(self, rows: Ints, excess: Floats, kind: str) -> _Bad | None:
        """The first of pieces ``rows`` (k,) with an ``excess`` (k, dof) above 0."""
        over = np.flatnonzero(excess.max(axis=1) > 0) if len(rows) else rows
        if not len(over):
            return None
        piece, joint = int(rows[over[0]]), self.guard.checker.robot.joints[int(excess[over[0]].argmax())]
        return _Bad(piece, float(self.chunk.times[piece]), Unsafe("limit", "motion", limit=kind, joint=joint))

    def unproven(self, stop: bool, bad: _Bad | None) -> _Bad | None:
        """The first piece or stop before ``bad`` that is not within limits, free and above the floor."""
        count = len(self.chunk.seconds) if bad is None else bad.piece
        stops, first = None, bad
        if stop:
            stops = self.stops_from(self.chunk.knots[1 : count + 1])
            without = np.flatnonzero(stops[1][:, 1] == 0.0)
            if len(without):
                count = int(without[0])
                first = self._no_stop(count, stops[2][count])
        taken = None if stops is None else (stops[0][:count], stops[1][:count])
        times = self.chunk.times[: count + 1]
        curves, spans, what = chunk_curves(self.chunk.coefficients[:count], times, taken, self.chunk.approach)
        found = self.first_refused(curves, spans, what[:, 1])
        if found is None:
            return first
        k, piece = found[0], int(what[found[0], 0])
        if found[2].on == "motion":
            return _Bad(piece, float(spans[k, 0] + found[1] * spans[k, 1]), found[2])
        return _Bad(piece, float(times[0 if found[2].on == "start" else piece + 1]), found[2])

    def first_refused(self, curves: Floats, spans: Floats, on: Ints) -> tuple[int, float, Unsafe] | None:
        """As :meth:`Guard.first_unproven`, of curves (m, degree + 1, dof) that keep conditions and the floor too."""
        found = self.guard.first_unproven(curves, spans, on) if len(curves) else None
        curves = curves if found is None else curves[: found[0]]
        for condition in self.guard.checker.world.conditions:
            holds = Keeps(self.guard.checker.robot, (condition,)).proven(curves)
            if not holds.all():
                k = int(holds.argmin())
                found, curves = (k, 0.0, Unsafe("kept", WHERE[on[k]], kept=condition.text)), curves[:k]
        if self.rules.floor > 0 and len(curves):
            holds = prove_floor(self.guard.checker.robot, curves, self.rules.floor).holds
            if not holds.all():
                k = int(holds.argmin())
                return k, 0.0, Unsafe("floor", WHERE[on[k]])
        return found

    def stops_from(self, knots: Floats) -> tuple[Floats, Floats, Ints]:
        """Stops (n, 2, 5, dof) from knots (n, 3, dof), their seconds (n, 2), what is in the way where they are 0."""
        bounds = self.rules.lower, self.rules.upper
        return stops_quickest(knots, RUNGS, self.rules.most * (1.0 + ROUNDING), bounds)

    def _no_stop(self, piece: int, broken: Ints) -> _Bad:
        kind, joint = (*KINDS, POSITION)[int(broken[0])], self.guard.checker.robot.joints[int(broken[1])]
        return _Bad(piece, float(self.chunk.times[piece + 1]), Unsafe("limit", "stop", limit=kind, joint=joint))

    def stop(self, pieces: int) -> Trajectory | None:
        """The proven motion to rest from the end of the first ``pieces`` on, if there is one."""
        robot, knot = self.guard.checker.robot, self.chunk.knots[pieces]
        (stops,), (seconds,), _ = self.stops_from(knot[None])
        if seconds[1] == 0.0:
            return None
        used, ends = seconds > 0.0, np.append(0.0, np.cumsum(seconds))
        spans = np.column_stack([self.chunk.times[pieces] + ends[:2], seconds, np.zeros(2)])[used]
        if self.first_refused(stops[used], spans, np.full(len(spans), WHERE.index("stop"))) is not None:
            return None
        columns = np.zeros((3, 3, robot.dof))  # q, qd, qdd where it begins, where the last piece begins, where it ends
        columns[:, 0], columns[0, 1], columns[0, 2] = knot, stops[1, 0], stops[1].sum(axis=0)
        columns[1, 1] = stops[1, 1] / seconds[1]
        rows = [0, 1, 2] if used[0] else [0, 2]
        return Trajectory.through(robot.joints, ends[rows], *columns[:, rows], law="stop")

    def clearance(self, pieces: int) -> float | None:
        """The smallest distance (m) along the first ``pieces``."""
        if pieces == 0:
            return None
        found = nearest_on_pieces(self.chunk.coefficients[:pieces], self.chunk.times[: pieces + 1], self.guard.checker)
        return None if found is None else found.min
