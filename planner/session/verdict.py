"""The verdict on a chunk of targets: limits, stops from all points, and one proof of all curves.

A stop is proven from every safe point. Between two points the robot follows the proven polynomial piece to the next
point and stops there, so a proven motion to rest exists at any time of the safe section.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints, numbers
from planner.base.errors import ArrayError, StateError, choices
from planner.base.polynomials import evaluate
from planner.constraints.floor import prove_floor
from planner.constraints.path_constraints import PathConstraints
from planner.native.compiled import Judgement, chunk_curves
from planner.session.guard import JUDGED, POSITION, Chunk, Guard
from planner.session.reasons import WHERE, Outcome, Violation
from planner.session.retiming import SCALES, ease_times, retime
from planner.trajectory.measure import nearest_on_pieces
from planner.trajectory.proof import ASSUMES
from planner.trajectory.trajectory import Trajectory

_LINES = "lines: velocity jumps at the points, so acceleration and jerk are not checked; stops begin without any"
_CUBICS = "cubics: acceleration jumps at the points, so only the jerk of stops is checked"
_ROUGH = "the state has no acceleration: the first polynomial piece is a cubic, and the jerk at its end is not checked"
_LED = "no state: the motion to the first point is not checked"
_BENT = "the state has no acceleration: the jerk at the first point is not checked"
_UNSTOPPED = "stop is False: whether the robot can stop is not checked"
_NOTES = {1: (_LINES,), 2: (_CUBICS,), 3: ()}  # by number of columns
_FREE, _AWAY, _BEYOND = range(3)  # as Reason in gate.hpp; 3: not proven
_STOP = WHERE.index("stop")


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """Whether a chunk is ``safe``, and until when; true as a bool if it is safe.

    ``safe_until`` (s from now): up to this point all polynomial pieces are proven, and a stop from every point; 0 if
    none is. ``reason`` explains the violation at ``first_bad`` s: where the proof of the first bad piece stopped, or
    the point without a proven stop. ``notes`` list unchecked limits. ``revision`` is that of the world of the check, in
    which ``stop`` and ``clearance`` are computed on demand.
    """

    safe: bool
    safe_until: float
    reason: Violation | None
    first_bad: float | None
    notes: tuple[str, ...]
    revision: int
    _guard: Guard
    _run: Callable[[], Chunk]  # the controller's motion
    _pieces: int  # number of safe pieces
    _with_stops: bool  # whether a stop is proven from the end of each safe piece
    _slow: Callable[[], tuple[float, Verdict] | None]  # the scale of time, and the verdict on the slower chunk

    def __bool__(self) -> bool:
        return self.safe

    def __repr__(self) -> str:
        return f"<Verdict: {self}>"

    def __str__(self) -> str:
        if self.safe:
            return f"safe until {self.safe_until:g} s"
        return f"unsafe at {self.first_bad:g} s: {self.reason}; safe until {self.safe_until:g} s"

    @property
    def outcome(self) -> Outcome:
        """Return "safe", "cut" if the chunk is safe up to a point, else "refused"."""
        return "safe" if self.safe else "cut" if self._pieces else "refused"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data without ``stop`` and ``clearance``; s."""
        data = {name: getattr(self, name) for name in ("safe", "safe_until", "first_bad", "revision")}
        return data | {"reason": self.reason and self.reason.to_dict(), "notes": list(self.notes)}

    @property
    def stop(self) -> Trajectory | None:
        """The proven motion to rest from ``safe_until``, its times from 0; never None of a safe chunk.

        None if no point is safe and no stop is proven from the robot's state, as it is too fast or too close. For a
        check without stops one is computed now, and can be None.
        """
        return self._stop_after(self._pieces)

    @property
    def clearance(self) -> float | None:
        """The smallest distance (m) along the safe pieces, to a tenth; None if nothing can touch.

        Pairs that are allowed to touch do not count.
        """
        chunk, n = self._run(), self._pieces
        nearest = nearest_on_pieces(chunk.coefficients[:n], chunk.times[: n + 1], self._guard.checker) if n else None
        return None if nearest is None else nearest.min

    @property
    def slower(self) -> Verdict | None:
        """The verdict on the same path in more time, whose ``stop`` begins at the end of ``slowed``.

        Computed on first access where the motion is free, but a stop is not, or a limit on velocity, acceleration or
        jerk is exceeded. The first of ``SCALES`` that is proven applies. None for safe chunks and without a proof.
        """
        found = self._slow()
        return found and found[1]

    @property
    def slowed(self) -> Trajectory | None:
        """The motion of ``slower``, with the chunk's first time and a longer duration; None without a proof."""
        slower = self.slower
        if slower is None:
            return None
        chunk = slower._run()
        first, rows = chunk.coefficients[0], len(chunk.coefficients[0]) // 2
        columns = np.moveaxis(chunk.knots[:, :rows], 1, 0).copy()
        units = np.array([1.0, 1.0, 2.0])[:rows] / chunk.seconds[0] ** np.arange(rows)
        columns[:, 0] = first[:rows] * units[:, None]  # the first knot can be the robot's state near it
        joints = self._guard.checker.robot.joints
        return self._record(Trajectory.from_points(joints, chunk.times, *columns, time_law="slowed"))

    @property
    def time_scale(self) -> float | None:
        """The factor above 1 by which ``slowed`` is slower once its rate has fallen; None without a proof."""
        found = self._slow()
        return found and found[0]

    def positions_at(self, times: Floats | Sequence[float] | float) -> Floats:
        """Return positions (k, dof) of the proven motion at ``times`` (k,) s from now.

        They follow the chunk until ``safe_until``, then ``stop``, then rest. Before a first point without a state they
        are those of the point. Raises :class:`ArrayError` for wrong shapes and negative times, and :class:`StateError`
        if ``stop`` is None.
        """
        t = numbers("times", np.atleast_1d(np.asarray(times, dtype=np.float64)), ("k",))
        if len(t) and t.min() < 0.0:
            raise ArrayError(f"times must be at least 0 s from now, got {t.min():g}: give later times.")
        stop, chunk, count = self.stop, self._run(), self._pieces
        if stop is None:
            raise StateError(f"positions need a proven stop from {self.safe_until:g} s, got none: stop the robot.")
        positions = stop.at(t - chunk.times[count])
        if count:
            piece = np.clip(np.searchsorted(chunk.times[:count], t, side="right") - 1, 0, count - 1)
            share = np.clip((t - chunk.times[piece]) / chunk.seconds[piece], 0.0, 1.0)
            on = t < chunk.times[count]
            positions[on] = evaluate(chunk.coefficients[piece[on]], share[on])
        return positions

    def _record(self, motion: Trajectory) -> Trajectory:
        """Return a motion that is proven with its record."""
        guard, pieces = self._guard, len(motion.seconds)
        record = {"pieces": pieces, "pieces_free": pieces, "collision": guard.checker.name}
        return replace(motion, proven=True, proof=record | guard.to_dict() | {"assumes": ASSUMES})

    def _stop_after(self, pieces: int) -> Trajectory | None:
        """Return the proven motion to rest behind the first ``pieces``, which are safe; None for none.

        The check has proven stops behind safe pieces; a stop from the robot's state is proven here.
        """
        guard, chunk = self._guard, self._run()
        robot, knot = guard.checker.robot, chunk.knots[pieces]
        (stops,), (seconds,), _ = guard.find_stops(knot[None])
        if seconds[1] == 0.0:
            return None
        used, ends = seconds > 0.0, np.append(0.0, np.cumsum(seconds))
        spans = np.column_stack([chunk.times[pieces] + ends[:2], seconds, np.zeros(2)])[used]
        on, known = np.full(len(spans), _STOP), self._with_stops and pieces > 0
        if not known and not (
            guard.prove_free(stops[used], spans) and _find_first_broken(guard, stops[used], spans, on) is None
        ):
            return None
        columns = np.zeros((3, 3, robot.dof))  # q, qd, qdd at the start, at the last piece, at the end
        columns[:, 0], columns[0, 1], columns[0, 2] = knot, stops[1, 0], stops[1].sum(axis=0)
        columns[1, 1] = stops[1, 1] / seconds[1]
        rows = [0, 1, 2] if used[0] else [0, 2]
        return self._record(Trajectory.from_points(robot.joints, ends[rows], *columns[:, rows], time_law="stop"))


def judge_chunk(guard: Guard, points: int, rows: int, state: int, given: Floats, stop: bool) -> Verdict:
    """Return the verdict on a chunk in the layout of :meth:`planner.native.compiled.NativeGate.check`."""
    dof = guard.native.dof
    judgement, arrays = guard.native.check(points, rows, state, given, stop)
    if not judgement.usable:
        raise ArrayError("numbers of a chunk must be small enough for a proof: give fewer or smaller numbers.")
    run, times = partial(Chunk.from_native, judgement, arrays, points, rows, dof), arrays[1 + dof : 2 + dof + points]
    notes = _NOTES[rows] + (_ROUGH,) * judgement.rough + (_LED,) * bool(times[0] > 0.0) + (_UNSTOPPED,) * (not stop)
    notes += (_BENT,) * (judgement.approached and rows == 3 and state == 2)
    if left := guard.rules.unchecked:
        notes += (f"limits on {choices(left)} are not checked: judged does not name them",)
    if guard.permits:
        notes += tuple(item.permission.text(guard.now) for item in guard.permits)
    bad = _find_first_bad(guard, judgement, arrays, run, stop)
    pieces, late, why = (judgement.pieces_made, None, None) if bad is None else bad
    slow = _Slower(partial(_find_slower, guard, run, rows, given[points:][: state * dof], why)) if why else _never
    return Verdict(bad is None, float(times[pieces]), why, late, notes, guard.revision, guard, run, pieces, stop, slow)


def _never() -> None:
    return None


class _Slower:
    """The search for a slower chunk, made and counted once, whichever of several threads asks first."""

    __slots__ = ("_alone", "_find", "_found", "_is_made")

    def __init__(self, find: Callable[[], tuple[float, Verdict] | None]) -> None:
        self._find, self._alone, self._is_made = find, threading.Lock(), False

    def __call__(self) -> tuple[float, Verdict] | None:
        with self._alone:
            if not self._is_made:
                self._found, self._is_made = self._find(), True
        return self._found


def _find_slower(
    guard: Guard, run: Callable[[], Chunk], rows: int, state: Floats, why: Violation
) -> tuple[float, Verdict] | None:
    """Return the first scale of time with a proof, and the verdict on that chunk; None without one."""
    chunk, dof = run(), guard.native.dof
    is_led = len(state) > 0 and chunk.approach is None
    is_rough = is_led and rows == 3 and len(state) == 2 * dof
    if is_rough:  # the cubic to the first point, as a quintic
        state = np.append(state, 2.0 * chunk.coefficients[0, 2] / chunk.seconds[0] ** 2)
    speed = np.abs(chunk.knots[:2, 1]).max(axis=0)
    for scale in SCALES:
        for ease in ease_times(speed, guard.rules.most, scale, rows == 1):
            if not _can_help(why):
                return None
            made = retime(chunk.times, chunk.coefficients, rows, scale, ease)
            if made is None:
                continue
            times, columns = made[0][is_led:], made[1][:, is_led:]
            given = np.concatenate([times, state, columns], axis=None)
            verdict = judge_chunk(guard, len(times), rows, len(state) // dof, given, True)
            if verdict.reason is None:
                guard.statistics.count("slowed")
                return scale, replace(verdict, notes=(*verdict.notes, *(_BENT,) * is_rough))
            why = verdict.reason
    return None


def _can_help(why: Violation) -> bool:
    """Whether a slower motion on the same path can be safe."""
    return why.on == "stop" or (why.on == "motion" and why.kind == "limit" and why.limit != POSITION)


def _find_first_bad(
    guard: Guard, judgement: Judgement, arrays: Floats, run: Callable[[], Chunk], stop: bool
) -> tuple[int, float, Violation] | None:
    """Return the first bad piece, or that before the first bad stop; its time (s), and its violation."""
    times = arrays[1 + guard.native.dof :]
    if judgement.pieces or judgement.approached:
        contact = guard.contact_at_start(run().knots[0, 0] if judgement.may_hold else None)
        if contact is not None:
            on = WHERE[1 - judgement.approached]
            return 0, float(times[0]), Violation("contact", on, (contact.first, contact.second))
    if guard.rules.floor > 0 or guard.checker.world.conditions or guard.permits:
        chunk, count = run(), judgement.pieces
        stops = guard.find_stops(chunk.knots[1 : count + 1])[:2] if stop else None
        curves, spans, what = chunk_curves(chunk.coefficients[:count], chunk.times[: count + 1], stops, chunk.approach)
        broken = _find_first_broken(guard, curves[: judgement.proven], spans, what[:, 1])
        if broken is not None:
            piece, place = what[broken[0]].tolist()
            return piece, float(times[piece + (place == _STOP)]), broken[1]
    if judgement.reason == _FREE:
        return None
    piece, time, why = (
        judgement.piece,
        float(times[judgement.piece + (judgement.place == _STOP)]),
        _explain(guard, judgement, arrays),
    )
    if why.on == "motion" and why.kind not in ("start", "limit"):
        time += float(arrays[0]) * (float(times[piece + 1]) - time)
    return piece, time, why


def _explain(guard: Guard, judgement: Judgement, arrays: Floats) -> Violation:
    """Return the violation at which the compiled check stopped."""
    checker, world, on = guard.checker, guard.checker.world, WHERE[judgement.place]
    joint, pair, touches = checker.robot.joints[judgement.joint], judgement.pair, judgement.touches
    if judgement.reason == _AWAY:
        return Violation("start", on, joint=joint)
    if judgement.reason == _BEYOND:
        return Violation("limit", on, limit=JUDGED[judgement.kind], joint=joint)
    if pair < 0:
        return Violation("undecided", on)
    contact = world.contact(pair)
    names = contact.first, contact.second
    if touches == 2:  # a shape is not convex
        touches = checker.gaps(arrays[1 : 1 + guard.native.dof], np.array([pair]))[0] <= world.margin
    if touches:
        return Violation("contact", on, names)
    limited = world.is_scene_pair(pair) and guard.limited[world.members(pair)[1]]
    return Violation("reach" if limited else "undecided", on, names)


def _find_first_broken(guard: Guard, curves: Floats, spans: Floats, on: Ints) -> tuple[int, Violation] | None:
    """Return the first of curves (m, degree + 1, dof) that breaks a constraint, the floor or a permission.

    ``spans`` (m, 3) are their times, ``on`` (m,) indices of ``WHERE``.
    """
    robot, violation = guard.checker.robot, None
    for condition in guard.checker.world.conditions:
        holds = PathConstraints(robot, (condition,)).prove(curves)
        if not holds.all():
            k = int(holds.argmin())
            violation, curves = (k, Violation("constraint", WHERE[on[k]], constraint=condition.text)), curves[:k]
    if guard.rules.floor > 0 and len(curves):
        holds = prove_floor(robot, curves, guard.rules.floor).holds
        if not holds.all():
            k = int(holds.argmin())
            violation, curves = (k, Violation("floor", WHERE[on[k]])), curves[:k]
    for permit in guard.permits:
        broken = permit.first_broken(curves, spans[: len(curves)], guard.now) if len(curves) else None
        if broken is not None:
            k, kind, pair = broken
            violation, curves = (k, Violation(kind, WHERE[on[k]], pair)), curves[:k]
    return violation
