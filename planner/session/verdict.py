"""The verdict on a chunk: limits, a stop from every point, and one proof of all curves together.

At every point of the safe part its own stop is proven. Between two points the robot runs on along the proven piece to
the next one and stops there: so from any moment of the safe part on there is a proven motion to rest.
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

RUNGS = frozen(np.round(2e7 * 1.2 ** np.arange(32)) / 1e9)  # s that a stop may take, to the nanosecond: up to 5.7
POSITION = "position"
JUDGED = (POSITION, *KINDS)

_LINES = "lines: their velocity jumps at the points, so acceleration and jerk are not judged; stops begin without any"
_CUBICS = "cubics: their acceleration jumps at the points, so the jerk is not judged; that of stops is"
_ROUGH = "the state has no acceleration: the first piece is a cubic, and the jerk is not judged where it ends"
_LED = "no state: what leads to the first point is not judged"
_BENT = "the state has no acceleration: the jerk at the first point is not judged"
_UNSTOPPED = "no stops were asked for: whether the robot can stop is not judged"
_NOTES = {1: (_LINES,), 2: (_CUBICS,), 3: ()}  # by the columns
_FREE, _AWAY, _BEYOND = range(3)  # numbers of reasons; 3: not proven

Kind = Literal["contact", "undecided", "reach", "limit", "floor", "kept", "start"]
Where = Literal["start", "motion", "stop"]
WHERE: tuple[Where, ...] = ("start", "motion", "stop")  # by the numbers that compiled code gives them
_STOP = WHERE.index("stop")

_HOW: dict[Kind, str] = {
    "contact": "'{0}' and '{1}' touch, or are closer than the margin",
    "undecided": "'{0}' and '{1}' are too near each other to prove that they keep apart",
    "reach": "'{1}' may be at '{0}' by then, for all that its speed limit says",
    "limit": "joint '{joint}' is beyond its limit on {limit}",
    "floor": "manipulability is not proven above the floor",
    "kept": "'{kept}' is not proven to be kept",
    "start": "joint '{joint}' is elsewhere, or moves otherwise, than the first point says, which is at 0 s",
}
_ON: dict[Where, str] = {
    "motion": "on the motion",
    "stop": "on the way to rest from there",
    "start": "between where the robot is and the first point",
}


class Chunk(NamedTuple):
    """What joint_trajectory_controller makes of points: pieces (n, degree + 1, dof) between ``times`` (n + 1,) s.

    Until the first point's time a piece leads there from where the robot is, of the highest degree that both know the
    derivatives for. Each takes ``seconds`` (n,). ``knots`` (n + 1, 3, dof): position, velocity and acceleration with
    which the motion comes to each of the times, at the first one those of the robot. ``approach`` (2, dof) is where the
    robot is and by how much the first point, which is at 0 s, is elsewhere; None where the first piece leads there.
    """

    times: Floats
    seconds: Floats
    coefficients: Floats
    knots: Floats
    approach: Floats | None

    @staticmethod
    def from_native(found: Judgement, made: Floats, points: int, rows: int, dof: int) -> Chunk:
        """The arrays that ``NativeGate.check`` has ``made``, in the order of source/python/gate.hpp."""
        sizes, n = (1 + dof, points + 1, points, points * 2 * rows * dof, 3 * (points + 1) * dof), found.pieces_made
        _, times, seconds, pieces, knots, approach = np.split(made, np.cumsum(sizes))
        return Chunk(
            times[: n + 1],
            seconds[:n],
            pieces.reshape(points, 2 * rows, dof)[:n],
            knots.reshape(points + 1, 3, dof)[: n + 1],
            approach.reshape(2, dof) if found.approached else None,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Rules:
    """Limits ``most`` (3, dof), with what rounding may add, infinite ones ask for nothing, and limits on positions.

    ``lower`` and ``upper`` (dof,) are those, infinite where they are not asked for.
    ``floor``: what manipulability keeps above, 0 for none; ``apart`` (rad, rad/s, rad/s²): of a point at 0 s from the
    state. Limits of kinds that are ``left`` are not asked for.
    """

    most: Floats
    lower: Floats
    upper: Floats
    floor: float
    apart: float
    left: tuple[str, ...]

    @staticmethod
    def from_limits(
        robot: Robot, limits: MotionLimits, judged: Sequence[str] = JUDGED, floor: float = 0.0, apart: float = 0.0
    ) -> Rules:
        """The rules that ask for those limits that are ``judged``; :class:`OptionError` for what makes no sense."""
        judged = judged if isinstance(judged, str) else tuple(judged)  # looked through more than once
        unknown = sorted({str(kind) for kind in judged} - set(JUDGED))
        if isinstance(judged, str) or unknown:
            raise OptionError(f"judged names {choices(unknown) or repr(judged)}: give a list out of {choices(JUDGED)}.")
        for name, value in (("min_manipulability", floor), ("start_tolerance", apart)):
            if not 0.0 <= value < np.inf:
                raise OptionError(f"{name} is {value:g}: give a number from 0 on.")
        none = np.full(len(limits.joints), np.inf)
        most = np.array([getattr(limits, kind) if kind in judged else none for kind in KINDS])
        left = tuple(kind for kind in JUDGED if kind not in judged)
        lower, upper = position_bounds(robot) if POSITION in judged else (-none, none)
        return Rules(most * (1.0 + ROUNDING), lower, upper, float(floor), float(apart), left)


@dataclass(frozen=True, slots=True, eq=False)
class Guard:
    """A ``checker`` and ``rules``; ``bounds`` on motions, which obstacles (o,) are ``limited``: what proofs need.

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
        """The guard of a world; :class:`SceneError` for obstacles that follow known motions."""
        world, robot = checker.world, checker.robot
        if world.scene.moving:
            names = choices(item.name for item in world.scene.moving)
            raise SceneError(
                f"in scene '{world.scene.name}' {names} moves along a known motion, and a gate cannot know since when: "
                "give it a speed_limit instead, and move it."
            )
        limited = np.array([item.speed_limit > 0 for item in world.obstacles], dtype=bool)
        bounds = checker.bound.motion_bounds
        if limited.any():  # these come to links that no joint moves
            still = ~world.moving
            still[: world.checked.size] &= ~np.tile(limited, len(world.bodies))
            bounds = checker.bound.native.bounds(world.pair_reach, world.reach.bodies, still)
        _ = checker.static_contact  # found now: no check waits for it
        native = NativeGate(
            checker.bound.native,
            bounds,
            checker.inside.boxes,
            bool(limited.any()),
            PROOF,
            (rules.most, rules.lower, rules.upper),
            (*position_bounds(robot), robot.continuous),
            RUNGS,
            rules.apart,
            FARTHEST,
        )
        return Guard(checker, rules, bounds, limited, native, revision)

    def contact_at_start(self, q: Floats | None) -> Contact | None:
        """What touches however the robot moves, or holds the other within it at ``q`` (dof,), if that is given."""
        pair = -1 if q is None else int(self.checker.inside.pairs(q[None])[0])
        return self.checker.static_contact or (self.checker.world.contact(pair) if pair >= 0 else None)

    def prove_free(self, curves: Floats, spans: Floats) -> bool:
        """Whether all of curves (m, degree + 1, dof), each where the last one ends, are proven free.

        ``spans`` (m, 3): when each begins, how long it takes, 0, s.
        """
        if not np.abs(curves).max() <= FARTHEST or self.contact_at_start(curves[0, 0]) is not None:
            return False
        native, timed = self.checker.bound.native, spans if self.limited.any() else None
        return not native.prove_together(self.bounds, curves, PROOF, timed)[0].any()

    def to_dict(self) -> dict[str, Any]:
        """The revision, and what is judged: kinds of limits, margin (m), floor, conditions."""
        world, rules = self.checker.world, self.rules
        judged = {"judged": [kind for kind in JUDGED if kind not in rules.left], "margin": world.margin}
        kept = {"min_manipulability": rules.floor, "constraint": list(world.constraints.texts)}
        return {"revision": self.revision, **judged, **kept}

    def find_stops(self, knots: Floats) -> tuple[Floats, Floats, Ints]:
        """Stops (n, 2, 5, dof) from knots (n, 3, dof), their seconds (n, 2), what is in the way where they are 0."""
        rules = self.rules
        return stops_quickest(knots, RUNGS, rules.most, (rules.lower, rules.upper))


@dataclass(frozen=True, slots=True)
class Violation:
    """Why a chunk is not safe, as data.

    ``kind``: "contact", "undecided" (neither proven nor refuted), "reach" (of an obstacle with a speed limit), "limit",
    "floor", "kept" (a condition on the motion), or "start" (not where, or as fast as, it begins). ``on``: "motion",
    "stop" or "start". ``pair``: the link and what it meets, None where joints go too far to prove anything; ``limit``
    and ``joint``: what is exceeded (position, velocity, acceleration, jerk); ``kept``: the condition.
    """

    kind: Kind
    on: Where
    pair: tuple[str, str] | None = None
    limit: str | None = None
    joint: str | None = None
    kept: str | None = None

    def __str__(self) -> str:
        if self.kind == "undecided" and self.pair is None:
            return f"{_ON[self.on]} joints go too far from one point to the next to prove anything"
        what = {"limit": self.limit, "joint": self.joint, "kept": self.kept}
        return f"{_ON[self.on]} {_HOW[self.kind].format(*(self.pair or ()), **what)}"

    def to_dict(self) -> dict[str, Any]:
        """As plain data, with the sentence."""
        return {**asdict(self), "text": str(self)}


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """Whether a chunk is ``safe``, and until when it is.

    ``safe_until`` (s from now): all pieces until this point of the chunk are proven, and a stop from every point until
    there; the time of the last point where it is safe, 0 where nothing is. ``reason`` says why not, at ``first_bad`` s:
    where on the first bad piece the proof stopped, or the point from which no stop is proven. A verdict is true where
    the chunk is safe. ``notes`` say what was not judged. ``revision`` is that of the world of the check: it grows with
    every change. ``stop`` and ``clearance`` are worked out when they are asked for, in that world.
    """

    safe: bool
    safe_until: float
    reason: Violation | None
    first_bad: float | None
    notes: tuple[str, ...]
    revision: int
    _guard: Guard  # of that world
    _run: Callable[[], Chunk]  # what the controller runs
    _pieces: int  # that are safe
    _with_stops: bool  # a stop is proven from the end of each

    def __bool__(self) -> bool:
        return self.safe

    def __repr__(self) -> str:
        return f"<Verdict: {self}>"

    def __str__(self) -> str:
        if self.safe:
            return f"safe until {self.safe_until:g} s"
        return f"unsafe at {self.first_bad:g} s: {self.reason}; safe until {self.safe_until:g} s"

    def to_dict(self) -> dict[str, Any]:
        """As plain data, without what is worked out later; s."""
        found = {name: getattr(self, name) for name in ("safe", "safe_until", "first_bad", "revision")}
        return found | {"reason": self.reason and self.reason.to_dict(), "notes": list(self.notes)}

    @property
    def stop(self) -> Trajectory | None:
        """The proven motion to rest from ``safe_until`` on, its times from 0 there; never None of a safe chunk.

        It is None where nothing is safe and no stop is proven from where the robot is, of a robot that is too fast or
        too near already. Where no stops were asked for one is sought now, and may not be there.
        """
        return self._stop_after(self._pieces)

    @property
    def clearance(self) -> float | None:
        """The smallest distance (m) along the safe part, to a tenth; None where nothing moves or can come near."""
        chunk, n = self._run(), self._pieces
        found = nearest_on_pieces(chunk.coefficients[:n], chunk.times[: n + 1], self._guard.checker) if n else None
        return None if found is None else found.min

    def _stop_after(self, pieces: int) -> Trajectory | None:
        """The proven motion to rest from the end of the first ``pieces``, which are safe, if there is one.

        Behind a safe piece the check has proven it; only that of a robot that is there now is proven here.
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
        columns = np.zeros((3, 3, robot.dof))  # q, qd, qdd where it begins, where the last piece begins, where it ends
        columns[:, 0], columns[0, 1], columns[0, 2] = knot, stops[1, 0], stops[1].sum(axis=0)
        columns[1, 1] = stops[1, 1] / seconds[1]
        rows = [0, 1, 2] if used[0] else [0, 2]
        made = Trajectory.from_points(robot.joints, ends[rows], *columns[:, rows], time_law="stop")
        pieces_free = {"pieces": len(spans), "pieces_free": len(spans), "collision": guard.checker.name}
        return replace(made, proven=True, proof=pieces_free | guard.to_dict() | {"assumes": ASSUMES})


def judge_chunk(guard: Guard, points: int, rows: int, state: int, given: Floats, stop: bool) -> Verdict:
    """The verdict on a chunk as :meth:`planner.native.compiled.NativeGate.check` takes it, with or without stops."""
    dof = guard.native.dof
    found, made = guard.native.check(points, rows, state, given, stop)
    if not found.usable:
        raise ArrayError("the chunk cannot be judged: give fewer or smaller numbers.")
    run, times = partial(Chunk.from_native, found, made, points, rows, dof), made[1 + dof : 2 + dof + points]
    notes = _NOTES[rows] + (_ROUGH,) * found.rough + (_LED,) * bool(times[0] > 0.0) + (_UNSTOPPED,) * (not stop)
    notes += (_BENT,) * (found.approached and rows == 3 and state == 2)
    if left := guard.rules.left:
        notes += (f"limits on {choices(left)} are not judged: they were not asked for",)
    bad = _find_first_bad(guard, found, made, run, stop)
    pieces, late, why = (found.pieces_made, None, None) if bad is None else bad
    return Verdict(bad is None, float(times[pieces]), why, late, notes, guard.revision, guard, run, pieces, stop)


def _find_first_bad(
    guard: Guard, found: Judgement, made: Floats, run: Callable[[], Chunk], stop: bool
) -> tuple[int, float, Violation] | None:
    """The first piece that is bad, or before the first bad stop; when (s), and why."""
    times = made[1 + guard.native.dof :]
    if found.pieces or found.approached:
        contact = guard.contact_at_start(run().knots[0, 0] if found.may_hold else None)
        if contact is not None:
            on = WHERE[1 - found.approached]
            return 0, float(times[0]), Violation("contact", on, (contact.first, contact.second))
    if guard.rules.floor > 0 or guard.checker.world.conditions:
        chunk, count = run(), found.pieces
        stops = guard.find_stops(chunk.knots[1 : count + 1])[:2] if stop else None
        curves, _, what = chunk_curves(chunk.coefficients[:count], chunk.times[: count + 1], stops, chunk.approach)
        broken = _find_first_broken(guard, curves[: found.proven], what[:, 1])
        if broken is not None:
            piece, place = what[broken[0]].tolist()
            return piece, float(times[piece + (place == _STOP)]), broken[1]
    if found.reason == _FREE:
        return None
    piece, time, why = found.piece, float(times[found.piece + (found.place == _STOP)]), _explain(guard, found, made)
    if why.on == "motion" and why.kind not in ("start", "limit"):
        time += float(made[0]) * (float(times[piece + 1]) - time)
    return piece, time, why


def _explain(guard: Guard, found: Judgement, made: Floats) -> Violation:
    """Why the compiled judgement stopped."""
    checker, world, on = guard.checker, guard.checker.world, WHERE[found.place]
    joint, pair, touches = checker.robot.joints[found.joint], found.pair, found.touches
    if found.reason == _AWAY:
        return Violation("start", on, joint=joint)
    if found.reason == _BEYOND:
        return Violation("limit", on, limit=JUDGED[found.kind], joint=joint)
    if pair < 0:
        return Violation("undecided", on)
    contact = world.contact(pair)
    names = contact.first, contact.second
    if touches == 2:  # one has dents
        touches = checker.gaps(made[1 : 1 + guard.native.dof], np.array([pair]))[0] <= world.margin
    if touches:
        return Violation("contact", on, names)
    limited = world.is_scene_pair(pair) and guard.limited[world.members(pair)[1]]
    return Violation("reach" if limited else "undecided", on, names)


def _find_first_broken(guard: Guard, curves: Floats, on: Ints) -> tuple[int, Violation] | None:
    """The first of curves (m, degree + 1, dof) that is not proven to keep conditions and floor, and why.

    ``on`` (m,): the place of what each curve is in ``WHERE``.
    """
    robot, found = guard.checker.robot, None
    for condition in guard.checker.world.conditions:
        holds = PathConstraints(robot, (condition,)).proven(curves)
        if not holds.all():
            k = int(holds.argmin())
            found, curves = (k, Violation("kept", WHERE[on[k]], kept=condition.text)), curves[:k]
    if guard.rules.floor > 0 and len(curves):
        holds = prove_floor(robot, curves, guard.rules.floor).holds
        if not holds.all():
            k = int(holds.argmin())
            return k, Violation("floor", WHERE[on[k]])
    return found
