"""A world at one moment, as the gate asks it: which curves of a robot that is on its way are proven free."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats
from planner.base.errors import SceneError, choices
from planner.base.resolutions import PROOF
from planner.base.yamlfile import FARTHEST
from planner.collision.checker import CollisionChecker
from planner.collision.world import Contact
from planner.native.compiled import NativeBounds, NativeGate
from planner.query.resolve import position_bounds
from planner.session.rules import JUDGED, RUNGS, Rules
from planner.session.verdict import Unsafe, Where

_REVISIONS = count()


@dataclass(frozen=True, slots=True, eq=False)
class Guard:
    """A ``checker`` and ``rules``; ``bounds`` on motions, which obstacles (o,) are ``limited``: what proofs need.

    ``revision`` grows with every change of a world, and no two worlds of a process share one.
    """

    checker: CollisionChecker
    rules: Rules
    bounds: NativeBounds
    limited: Bools
    native: NativeGate
    revision: int

    @staticmethod
    def of(checker: CollisionChecker, rules: Rules) -> Guard:
        """The guard of a world; :class:`SceneError` for obstacles of known motions, whose clock nobody gives."""
        world, robot = checker.world, checker.robot
        if world.scene.moving:
            raise SceneError(
                f"in scene '{world.scene.name}' {choices(item.name for item in world.scene.moving)} moves along a "
                "known motion, and a gate cannot know since when: give it a speed_limit instead, and move it."
            )
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
        return Guard(checker, rules, bounds, limited, native, next(_REVISIONS))

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

    def not_proven(self, on: Where, pair: int, touches: int, q: Floats) -> Unsafe:
        """Why the proof of a curve stopped at ``pair`` in ``q`` (dof,), by what :class:`Judgement` says of it."""
        checker, world = self.checker, self.checker.world
        if pair < 0:
            return Unsafe("undecided", on)
        contact = world.contact(pair)
        names = contact.first, contact.second
        if touches == 2:  # one has dents
            touches = checker.gaps(q, np.array([pair]))[0] <= world.margin
        if touches:
            return Unsafe("contact", on, names)
        limited = world.is_scene_pair(pair) and self.limited[world.members(pair)[1]]
        return Unsafe("reach" if limited else "undecided", on, names)
