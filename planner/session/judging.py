"""The judgement on a chunk: limits, a stop from every point, and one proof of all curves together.

At every point of the safe part its own stop is proven. Between two points the robot runs on along the proven piece to
the next one and stops there: so from any moment of the safe part on there is a proven motion to rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import ArrayError, choices
from planner.constraints.keeps import Keeps
from planner.kinematics.manipulability_proof import prove_floor
from planner.native.compiled import Judgement, chunk_curves, stops_quickest
from planner.native.gate import Chunk
from planner.session.chunk import Given, read_chunk
from planner.session.guard import Guard
from planner.session.rules import JUDGED, RUNGS
from planner.session.verdict import WHERE, Unsafe, Verdict
from planner.trajectory.clearance import nearest_on_pieces
from planner.trajectory.proof import ASSUMES
from planner.trajectory.trajectory import Trajectory

_LINES = "lines: their velocity jumps at the points, so acceleration and jerk are not judged; stops begin without any"
_CUBICS = "cubics: their acceleration jumps at the points, so the jerk is not judged; that of stops is"
_ROUGH = "the state has no acceleration: the first piece is a cubic, and the jerk is not judged where it ends"
_LED = "no state: what leads to the first point is not judged"
_BENT = "the state has no acceleration: the jerk at the first point is not judged"
_UNSTOPPED = "no stops were asked for: whether the robot can stop is not judged"
_NOTES = {1: (_LINES,), 2: (_CUBICS,), 3: ()}  # by the columns
_FREE, _AWAY, _BEYOND = range(3)  # numbers of reasons; 3: not proven
_STOP = WHERE.index("stop")


def judge(guard: Guard, asked: tuple[Any, ...], stop: bool) -> Verdict:
    """The verdict on what :func:`read_chunk` reads, with or without stops; raises what that does."""
    judged = Judged.of(guard, read_chunk(guard.checker.robot, *asked), stop)
    if not judged.found.usable:
        raise ArrayError("the chunk cannot be judged: give fewer or smaller numbers.")
    return judged.verdict()


@dataclass(frozen=True, slots=True, eq=False)
class _Bad:
    """The first bad piece, or the piece before the first bad stop, when (s), and why."""

    piece: int
    time: float
    why: Unsafe


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A chunk in the world of its check: what was ``found``, and the arrays that were ``made`` of it."""

    guard: Guard
    given: Given
    with_stops: bool
    found: Judgement
    made: Floats

    @staticmethod
    def of(guard: Guard, given: Given, stop: bool) -> Judged:
        """The chunk that is ``given``, if it is usable."""
        found, made = guard.native.check(given.points, given.rows, given.state, given.row, stop)
        return Judged(guard, given, stop, found, made)

    def verdict(self) -> Verdict:
        """What a user is told."""
        bad, found, notes = self._bad(), self.found, _NOTES[self.given.rows]
        notes += (_ROUGH,) * found.rough + (_LED,) * (self._time(0) > 0.0) + (_UNSTOPPED,) * (not self.with_stops)
        notes += (_BENT,) * (found.approached and self.given.rows == 3 and self.given.state == 2)
        if left := self.guard.rules.left:
            notes += (f"limits on {choices(left)} are not judged: they were not asked for",)
        of = notes, self.guard.revision, self
        if bad is None:
            return Verdict(True, self._time(found.pieces_made), None, None, *of, found.pieces_made)
        return Verdict(False, self._time(bad.piece), bad.why, bad.time, *of, bad.piece)

    @property
    def chunk(self) -> Chunk:
        """What the controller runs."""
        return Chunk.of(self.found, self.made, self.given.points, self.given.rows, self.guard.native.dof)

    def _time(self, point: int) -> float:
        return float(self.made[1 + self.guard.native.dof + point])

    def _bad(self) -> _Bad | None:
        found, guard = self.found, self.guard
        if found.pieces or found.approached:
            contact = guard.contact_at_start(self._start() if found.may_hold else None)
            if contact is not None:
                on = WHERE[1 - found.approached]
                return _Bad(0, self._time(0), Unsafe("contact", on, (contact.first, contact.second)))
        if guard.rules.floor > 0 or guard.checker.world.conditions:
            curves, _, what = self._curves()
            broken = _first_not_kept(guard, curves[: found.proven], what[:, 1])
            if broken is not None:
                return self._bad_at(int(what[broken[0], 1]), int(what[broken[0], 0]), 0.0, broken[1])
        if found.reason == _FREE:
            return None
        return self._bad_at(found.place, found.piece, float(self.made[0]), self._why())

    def _bad_at(self, place: int, piece: int, share: float, why: Unsafe) -> _Bad:
        time = self._time(piece + (place == _STOP))
        if why.kind not in ("start", "limit") and WHERE[place] == "motion":
            time += share * (self._time(piece + 1) - time)
        return _Bad(piece, time, why)

    def _why(self) -> Unsafe:
        found, guard = self.found, self.guard
        on, joint = WHERE[found.place], guard.checker.robot.joints[found.joint]
        if found.reason == _AWAY:
            return Unsafe("start", on, joint=joint)
        if found.reason == _BEYOND:
            return Unsafe("limit", on, limit=JUDGED[found.kind], joint=joint)
        return guard.not_proven(on, found.pair, found.touches, self.made[1 : 1 + guard.native.dof])

    def _start(self) -> Floats:
        """Where the robot is (dof,), or where the first piece begins."""
        return self.chunk.knots[0, 0]

    def _curves(self) -> tuple[Floats, Floats, Ints]:
        """All that is proven, as :func:`chunk_curves` has it."""
        chunk, count = self.chunk, self.found.pieces
        stops = self.stops_from(chunk.knots[1 : count + 1])[:2] if self.with_stops else None
        return chunk_curves(chunk.coefficients[:count], chunk.times[: count + 1], stops, chunk.approach)

    def stops_from(self, knots: Floats) -> tuple[Floats, Floats, Ints]:
        """Stops (n, 2, 5, dof) from knots (n, 3, dof), their seconds (n, 2), what is in the way where they are 0."""
        rules = self.guard.rules
        return stops_quickest(knots, RUNGS, rules.most, (rules.lower, rules.upper))

    def stop(self, pieces: int) -> Trajectory | None:
        """The proven motion to rest from the end of the first ``pieces``, which are safe, if there is one.

        Behind a safe piece the judgement has proven it; only that of a robot that is there now is proven here.
        """
        robot, chunk = self.guard.checker.robot, self.chunk
        knot = chunk.knots[pieces]
        (stops,), (seconds,), _ = self.stops_from(knot[None])
        if seconds[1] == 0.0:
            return None
        used, ends = seconds > 0.0, np.append(0.0, np.cumsum(seconds))
        spans = np.column_stack([chunk.times[pieces] + ends[:2], seconds, np.zeros(2)])[used]
        on, known = np.full(len(spans), _STOP), self.with_stops and pieces > 0
        if not known and not (
            self.guard.proven(stops[used], spans) and _first_not_kept(self.guard, stops[used], on) is None
        ):
            return None
        columns = np.zeros((3, 3, robot.dof))  # q, qd, qdd where it begins, where the last piece begins, where it ends
        columns[:, 0], columns[0, 1], columns[0, 2] = knot, stops[1, 0], stops[1].sum(axis=0)
        columns[1, 1] = stops[1, 1] / seconds[1]
        rows = [0, 1, 2] if used[0] else [0, 2]
        made = Trajectory.through(robot.joints, ends[rows], *columns[:, rows], law="stop")
        pieces_free = {"pieces": len(spans), "pieces_free": len(spans), "collision": self.guard.checker.name}
        return replace(made, proven=True, proof=pieces_free | self.guard.to_dict() | {"assumes": ASSUMES})

    def clearance(self, pieces: int) -> float | None:
        """The smallest distance (m) along the first ``pieces``."""
        if pieces == 0:
            return None
        chunk = self.chunk
        found = nearest_on_pieces(chunk.coefficients[:pieces], chunk.times[: pieces + 1], self.guard.checker)
        return None if found is None else found.min


def _first_not_kept(guard: Guard, curves: Floats, on: Ints) -> tuple[int, Unsafe] | None:
    """The first of curves (m, degree + 1, dof) that is not proven to keep conditions and floor, and why.

    ``on`` (m,): the place of what each curve is in ``WHERE``.
    """
    robot, found = guard.checker.robot, None
    for condition in guard.checker.world.conditions:
        holds = Keeps(robot, (condition,)).proven(curves)
        if not holds.all():
            k = int(holds.argmin())
            found, curves = (k, Unsafe("kept", WHERE[on[k]], kept=condition.text)), curves[:k]
    if guard.rules.floor > 0 and len(curves):
        holds = prove_floor(robot, curves, guard.rules.floor).holds
        if not holds.all():
            k = int(holds.argmin())
            return k, Unsafe("floor", WHERE[on[k]])
    return found
