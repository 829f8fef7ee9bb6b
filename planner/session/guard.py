"""A world with the rules of a gate, and chunks as the compiled check returns them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.errors import OptionError, SceneError, choices
from planner.base.resolutions import PROOF
from planner.base.yamlfile import FARTHEST
from planner.collision.checker import CollisionChecker
from planner.collision.world import Contact
from planner.native.compiled import Judgement, NativeBounds, NativeGate, stops_quickest
from planner.query.resolve import position_bounds
from planner.robot.robot import Robot
from planner.session.permissions import Permission, Permit, motion_bounds
from planner.session.reasons import Statistics
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.proof import ROUNDING

RUNGS = frozen(np.round(2e7 * 1.2 ** np.arange(32)) / 1e9)  # s of a stop, in whole nanoseconds, up to 5.7
POSITION = "position"
JUDGED = (POSITION, *KINDS)


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

    ``revision`` is that of the live world. The checker leaves out the pairs of ``permits``, which are proven apart from
    it; ``now`` (s of ``time.monotonic``) is the time of a check.
    """

    checker: CollisionChecker
    rules: Rules
    bounds: NativeBounds
    limited: Bools
    native: NativeGate
    revision: int
    statistics: Statistics
    permissions: tuple[Permission, ...] = ()
    permits: tuple[Permit, ...] = ()
    now: float = 0.0

    @staticmethod
    def from_checker(
        checker: CollisionChecker,
        revision: int,
        rules: Rules,
        statistics: Statistics,
        permissions: tuple[Permission, ...] = (),
    ) -> Guard:
        """Return the guard of a world; :class:`SceneError` for obstacles that follow known motions."""
        world, robot = checker.world, checker.robot
        if world.scene.moving:
            names = choices(item.name for item in world.scene.moving)
            raise SceneError(
                f"obstacles of a gate must not move along known motions, got {names} in scene '{world.scene.name}': "
                "give a speed_limit instead, and move the obstacle."
            )
        permits = tuple(Permit(item, checker) for item in permissions if item.pairs_in(world).any())
        if permits:
            left_out = np.any([item.permission.pairs_in(world) for item in permits], axis=0)
            checker = type(checker)(world.without(left_out), checker)
        limited = np.array([item.speed_limit > 0 for item in world.obstacles], dtype=bool)
        bounds = motion_bounds(checker, limited)
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
        return Guard(checker, rules, bounds, limited, native, revision, statistics, permissions, permits)

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
        allowed = [item.permission.to_dict(self.now) for item in self.permits]
        return {"revision": self.revision, **judged, **conditions} | ({"allowed": allowed} if allowed else {})

    def find_stops(self, knots: Floats) -> tuple[Floats, Floats, Ints]:
        """Return stops (n, 2, 5, dof) from knots (n, 3, dof), their seconds (n, 2), and what prevents them."""
        rules = self.rules
        return stops_quickest(knots, RUNGS, rules.most, (rules.lower, rules.upper))
