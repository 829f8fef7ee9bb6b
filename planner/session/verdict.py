"""The verdict on a chunk of targets: limits, stops from all points, and one proof of all curves.

A stop is proven from every safe point. Between two points the robot follows the proven polynomial piece to the next
point and stops there, so a proven motion to rest exists at any time of the safe section.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.errors import ArrayError, OptionError, SceneError, choices
from planner.base.resolutions import PROOF
from planner.base.yamlfile import FARTHEST
from planner.collision.checker import CollisionChecker
from planner.collision.world import Contact
from planner.constraints.floor import prove_floor
from planner.constraints.path_constraints import PathConstraints
from planner.native.compiled import Judgement, NativeBounds, NativeGate, chunk_curves, stops_quickest
from planner.query.resolve import position_bounds
from planner.robot.robot import Robot
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.measure import nearest_on_pieces
from planner.trajectory.proof import ASSUMES, ROUNDING
from planner.trajectory.trajectory import Trajectory

RUNGS = frozen(np.round(2e7 * 1.2 ** np.arange(32)) / 1e9)  # s of a stop, in whole nanoseconds, up to 5.7
POSITION = "position"
JUDGED = (POSITION, *KINDS)

_LINES = "lines: velocity jumps at the points, so acceleration and jerk are not checked; stops begin without any"
_CUBICS = "cubics: acceleration jumps at the points, so only the jerk of stops is checked"
_ROUGH = "the state has no acceleration: the first polynomial piece is a cubic, and the jerk at its end is not checked"
_LED = "no state: the motion to the first point is not checked"
_BENT = "the state has no acceleration: the jerk at the first point is not checked"
_UNSTOPPED = "stop is False: whether the robot can stop is not checked"
_NOTES = {1: (_LINES,), 2: (_CUBICS,), 3: ()}  # by number of columns
_FREE, _AWAY, _BEYOND = range(3)  # as Reason in gate.hpp; 3: not proven

Kind = Literal["contact", "undecided", "reach", "limit", "floor", "constraint", "start"]
Where = Literal["start", "motion", "stop"]
WHERE: tuple[Where, ...] = ("start", "motion", "stop")  # as Place in gate.hpp
_STOP = WHERE.index("stop")

_HOW: dict[Kind, str] = {
    "contact": "'{0}' and '{1}' touch, or are closer than the margin",
    "undecided": "'{0}' and '{1}' are too close to prove that they do not touch",
    "reach": "'{1}' can reach '{0}' by that time within its speed limit",
    "limit": "joint '{joint}' is beyond its limit on {limit}",
    "floor": "manipulability is not proven above the floor",
    "constraint": "constraint '{constraint}' is not proven",
    "start": "joint '{joint}' has another position or velocity than the first point, which is at 0 s",
}
_ON: dict[Where, str] = {
    "motion": "on the motion",
    "stop": "on the way to rest from there",
    "start": "between the robot's state and the first point",
}


class Chunk(NamedTuple):
    """Polynomial pieces (n, degree + 1, dof) of joint_trajectory_controller between ``times`` (n + 1,) s.

    If the first point is after 0 s, a piece leads there from the robot's state, of the highest degree for which both
    have derivatives. Each piece takes ``seconds`` (n,). ``knots`` (n + 1, 3, dof) are position, velocity and
    acceleration at the end of each piece, the first those of the robot. ``approach`` (2, dof): position of the robot,
    and its offset to a first point at 0 s; None if the first piece leads there.
    """

    times: Floats
    seconds: Floats
    coefficients: Floats
    knots: Floats
    approach: Floats | None

    @staticmethod
    def from_native(judgement: Judgement, arrays: Floats, points: int, rows: int, dof: int) -> Chunk:
        """Split the array of ``NativeGate.check``, in the order of source/python/gate.hpp."""
        sizes, n = (1 + dof, points + 1, points, points * 2 * rows * dof, 3 * (points + 1) * dof), judgement.pieces_made
        _, times, seconds, pieces, knots, approach = np.split(arrays, np.cumsum(sizes))
        return Chunk(
            times[: n + 1],
            seconds[:n],
            pieces.reshape(points, 2 * rows, dof)[:n],
            knots.reshape(points + 1, 3, dof)[: n + 1],
            approach.reshape(2, dof) if judgement.approached else None,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Rules:
    """Limits of a gate: ``most`` (3, dof) on derivatives, and ``lower``, ``upper`` (dof,).

    Infinite limits are not checked; ``unchecked`` names their kinds. ``floor`` is the least manipulability, 0 for none.
    ``start_tolerance`` (rad, rad/s, rad/s²) is the largest distance of a point at 0 s from the state.
    """

    most: Floats
    lower: Floats
    upper: Floats
    floor: float
    start_tolerance: float
    unchecked: tuple[str, ...]

    @staticmethod
    def from_limits(
        robot: Robot, limits: MotionLimits, judged: Sequence[str] = JUDGED, floor: float = 0.0, tolerance: float = 0.0
    ) -> Rules:
        """Return the rules with limits of the kinds ``judged``; :class:`OptionError` for invalid values."""
        judged = judged if isinstance(judged, str) else tuple(judged)  # an iterator can be read only once
        unknown = sorted({str(kind) for kind in judged} - set(JUDGED))
        if isinstance(judged, str) or unknown:
            raise OptionError(f"judged must be a list of {choices(JUDGED)}, got {choices(unknown) or repr(judged)}.")
        for name, value in (("min_manipulability", floor), ("start_tolerance", tolerance)):
            if not 0.0 <= value < np.inf:
                raise OptionError(f"{name} must be at least 0 and finite, got {value:g}.")
        none = np.full(len(limits.joints), np.inf)
        most = np.array([getattr(limits, kind) if kind in judged else none for kind in KINDS])
        unchecked = tuple(kind for kind in JUDGED if kind not in judged)
        lower, upper = position_bounds(robot) if POSITION in judged else (-none, none)
        return Rules(most * (1.0 + ROUNDING), lower, upper, float(floor), float(tolerance), unchecked)


@dataclass(frozen=True, slots=True, eq=False)
class Guard:
    """Checker, rules, ``bounds`` on motions, and which obstacles (o,) have a speed limit (``limited``).

    ``revision`` is that of the live world.
    """

    checker: CollisionChecker
    rules: Rules
    bounds: NativeBounds
    limited: Bools
    native: NativeGate
    revision: int

    @staticmethod
    def from_checker(checker: CollisionChecker, revision: int, rules: Rules) -> Guard:
        """Return the guard of a world; :class:`SceneError` for obstacles that follow known motions."""
        world, robot = checker.world, checker.robot
        if world.scene.moving:
            names = choices(item.name for item in world.scene.moving)
            raise SceneError(
                f"obstacles of a gate must not move along known motions, got {names} in scene '{world.scene.name}': "
                "give a speed_limit instead, and move the obstacle."
            )
        limited = np.array([item.speed_limit > 0 for item in world.obstacles], dtype=bool)
        bounds = checker.bound.motion_bounds
        if limited.any():  # these can reach links that no joint moves
            still = ~world.moving
            still[: world.checked.size] &= ~np.tile(limited, len(world.bodies))
            bounds = checker.bound.native.bounds(world.pair_reach, world.reach.bodies, still)
        _ = checker.static_contact  # computed now, so no check waits for it
        native = NativeGate(
            checker.bound.native,
            bounds,
            checker.inside.boxes,
            bool(limited.any()),
            PROOF,
            (rules.most, rules.lower, rules.upper),
            (*position_bounds(robot), robot.continuous),
            RUNGS,
            rules.start_tolerance,
            FARTHEST,
        )
        return Guard(checker, rules, bounds, limited, native, revision)

    def contact_at_start(self, q: Floats | None) -> Contact | None:
        """Return a contact that no motion ends, or of one body inside another at ``q`` (dof,); None for none."""
        pair = -1 if q is None else int(self.checker.inside.pairs(q[None])[0])
        return self.checker.static_contact or (self.checker.world.contact(pair) if pair >= 0 else None)

    def prove_free(self, curves: Floats, spans: Floats) -> bool:
        """Prove connected curves (m, degree + 1, dof) free; ``spans`` (m, 3): begin, duration, 0, s."""
        if not np.abs(curves).max() <= FARTHEST or self.contact_at_start(curves[0, 0]) is not None:
            return False
        native, timed = self.checker.bound.native, spans if self.limited.any() else None
        return not native.prove_together(self.bounds, curves, PROOF, timed)[0].any()

    def to_dict(self) -> dict[str, Any]:
        """Return revision, kinds of limits, margin (m), floor and constraints as plain data."""
        world, rules = self.checker.world, self.rules
        judged = {"judged": [kind for kind in JUDGED if kind not in rules.unchecked], "margin": world.margin}
        conditions = {"min_manipulability": rules.floor, "constraint": list(world.constraints.texts)}
        return {"revision": self.revision, **judged, **conditions}

    def find_stops(self, knots: Floats) -> tuple[Floats, Floats, Ints]:
        """Return stops (n, 2, 5, dof) from knots (n, 3, dof), their seconds (n, 2), and what prevents them."""
        rules = self.rules
        return stops_quickest(knots, RUNGS, rules.most, (rules.lower, rules.upper))


@dataclass(frozen=True, slots=True)
class Violation:
    """Why a chunk is not safe, as data.

    ``kind``: "contact", "undecided" (neither proven nor refuted), "reach" (of an obstacle with a speed limit), "limit",
    "floor", "constraint", or "start" (the first point differs from the state). ``on``: "motion", "stop" or "start".
    ``pair``: the two bodies, None if joints move too far for a proof. ``limit`` (position, velocity, acceleration or
    jerk) and ``joint``: the exceeded limit. ``constraint``: the violated constraint.
    """

    kind: Kind
    on: Where
    pair: tuple[str, str] | None = None
    limit: str | None = None
    joint: str | None = None
    constraint: str | None = None

    def __str__(self) -> str:
        if self.kind == "undecided" and self.pair is None:
            return f"{_ON[self.on]} joints move too far between two points for a proof"
        what = {"limit": self.limit, "joint": self.joint, "constraint": self.constraint}
        return f"{_ON[self.on]} {_HOW[self.kind].format(*(self.pair or ()), **what)}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, with the sentence."""
        return {**asdict(self), "text": str(self)}


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

    def __bool__(self) -> bool:
        return self.safe

    def __repr__(self) -> str:
        return f"<Verdict: {self}>"

    def __str__(self) -> str:
        if self.safe:
            return f"safe until {self.safe_until:g} s"
        return f"unsafe at {self.first_bad:g} s: {self.reason}; safe until {self.safe_until:g} s"

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
        """The smallest distance (m) along the safe pieces, to a tenth; None if nothing can touch."""
        chunk, n = self._run(), self._pieces
        nearest = nearest_on_pieces(chunk.coefficients[:n], chunk.times[: n + 1], self._guard.checker) if n else None
        return None if nearest is None else nearest.min

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
            guard.prove_free(stops[used], spans) and _find_first_broken(guard, stops[used], on) is None
        ):
            return None
        columns = np.zeros((3, 3, robot.dof))  # q, qd, qdd at the start, at the last piece, at the end
        columns[:, 0], columns[0, 1], columns[0, 2] = knot, stops[1, 0], stops[1].sum(axis=0)
        columns[1, 1] = stops[1, 1] / seconds[1]
        rows = [0, 1, 2] if used[0] else [0, 2]
        motion = Trajectory.from_points(robot.joints, ends[rows], *columns[:, rows], time_law="stop")
        pieces_free = {"pieces": len(spans), "pieces_free": len(spans), "collision": guard.checker.name}
        return replace(motion, proven=True, proof=pieces_free | guard.to_dict() | {"assumes": ASSUMES})


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
    bad = _find_first_bad(guard, judgement, arrays, run, stop)
    pieces, late, why = (judgement.pieces_made, None, None) if bad is None else bad
    return Verdict(bad is None, float(times[pieces]), why, late, notes, guard.revision, guard, run, pieces, stop)


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
    if guard.rules.floor > 0 or guard.checker.world.conditions:
        chunk, count = run(), judgement.pieces
        stops = guard.find_stops(chunk.knots[1 : count + 1])[:2] if stop else None
        curves, _, what = chunk_curves(chunk.coefficients[:count], chunk.times[: count + 1], stops, chunk.approach)
        broken = _find_first_broken(guard, curves[: judgement.proven], what[:, 1])
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


def _find_first_broken(guard: Guard, curves: Floats, on: Ints) -> tuple[int, Violation] | None:
    """Return the first of curves (m, degree + 1, dof) without a proof of constraints and floor.

    ``on`` (m,) are indices of ``WHERE``.
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
            return k, Violation("floor", WHERE[on[k]])
    return violation
