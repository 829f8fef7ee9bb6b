"""A world at one moment, as the gate asks it, and the rules that the gate keeps in every world."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.errors import OptionError, SceneError, choices
from planner.base.resolutions import PROOF
from planner.base.yamlfile import FARTHEST
from planner.collision.checker import CollisionChecker
from planner.collision.world import Contact
from planner.native.compiled import NativeBounds, NativeGate, stops_quickest
from planner.query.resolve import position_bounds
from planner.robot.moving import MovingObstacle
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Obstacle
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.proof import ROUNDING

RUNGS = frozen(np.round(2e7 * 1.2 ** np.arange(32)) / 1e9)  # s that a stop may take, to the nanosecond: up to 5.7
POSITION = "position"
JUDGED = (POSITION, *KINDS)


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
    def of(
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
    def of(checker: CollisionChecker, revision: int, rules: Rules) -> Guard:
        """The guard of a world; :class:`SceneError` for obstacles that follow known motions."""
        world, robot = checker.world, checker.robot
        require_still(world.scene, world.scene.moving)
        limited = np.array([item.speed_limit > 0 for item in world.obstacles], dtype=bool)
        bounds = checker.bound.of_all
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

    def proven(self, curves: Floats, spans: Floats) -> bool:
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
        kept = {"min_manipulability": rules.floor, "keep": list(world.keeps.texts)}
        return {"revision": self.revision, **judged, **kept}

    def stops_from(self, knots: Floats) -> tuple[Floats, Floats, Ints]:
        """Stops (n, 2, 5, dof) from knots (n, 3, dof), their seconds (n, 2), what is in the way where they are 0."""
        rules = self.rules
        return stops_quickest(knots, RUNGS, rules.most, (rules.lower, rules.upper))


def require_still(scene: Scene, obstacles: Iterable[Obstacle | MovingObstacle]) -> None:
    """Raise :class:`SceneError` for obstacles that follow known motions, as a gate does not know since when."""
    names = [item.name for item in obstacles if isinstance(item, MovingObstacle)]
    if names:
        raise SceneError(
            f"in scene '{scene.name}' {choices(names)} moves along a known motion, and a gate cannot know since when: "
            "give it a speed_limit instead, and move it."
        )
