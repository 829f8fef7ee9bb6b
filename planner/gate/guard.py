"""A world at one moment, as the gate asks it: which curves of a robot that is on its way are proven free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import SceneError, choices
from planner.base.resolutions import PROOF
from planner.collision.checker import CollisionChecker
from planner.gate.verdict import WHERE, Kind, Unsafe, Where
from planner.kinematics.forward import joint_placements
from planner.native.library import NativeBounds


@dataclass(frozen=True, slots=True, eq=False)
class Guard:
    """A ``checker`` with what proofs need: ``bounds`` on motions, and which obstacles (o,) have speed limits."""

    checker: CollisionChecker
    bounds: NativeBounds
    limited: Bools

    @staticmethod
    def of(checker: CollisionChecker) -> Guard:
        """The guard of a world; :class:`SceneError` for obstacles of known motions, whose clock nobody gives."""
        world = checker.world
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
        _ = checker.inside, checker.static_contact  # found now: no check waits for them
        return Guard(checker, bounds, limited)

    def first_unproven(self, curves: Floats, spans: Floats | None, on: Ints) -> tuple[int, float, Unsafe] | None:
        """The first of curves (m, degree + 1, dof) that is not proven free, where on it, in [0, 1], and why.

        Each lies near the ones before and behind it, the first begins where the robot is. ``spans`` (m, 3): when each
        begins, how long it takes, 0, s; needed where obstacles have speed limits. ``on`` (m,): the place of
        what each curve is in ``WHERE``.
        """
        checker, contact = self.checker, self.checker.static_contact
        if contact is not None:
            return 0, 0.0, Unsafe("contact", WHERE[on[0]], (contact.first, contact.second))
        spans = spans if self.limited.any() else None
        enclosed = int(checker.inside.pairs(curves[:1, 0])[0])
        if enclosed >= 0:
            return 0, 0.0, self._unsafe("contact", WHERE[on[0]], enclosed)
        verdict, pair, where = checker.bound.native.prove_together(self.bounds, curves, PROOF, spans)
        k = int(verdict.argmax())
        if verdict[k] == 0:
            return None
        return k, float(where[k]), self._why(curves[k], float(where[k]), int(pair[k]), WHERE[on[k]])

    def _why(self, curve: Floats, u: float, pair: int, on: Where) -> Unsafe:
        checker = self.checker
        q = u ** np.arange(len(curve)) @ curve
        rotation, position = joint_placements(checker.chain, q[None])
        gap = checker.distances(rotation[:, 0], position[:, 0], np.array([pair]))[0]
        if gap <= checker.world.margin:
            return self._unsafe("contact", on, pair)
        limited = checker.world.is_scene_pair(pair) and self.limited[checker.world.members(pair)[1]]
        return self._unsafe("reach" if limited else "undecided", on, pair)

    def _unsafe(self, kind: Kind, on: Where, pair: int) -> Unsafe:
        contact = self.checker.world.contact(pair)
        return Unsafe(kind, on, (contact.first, contact.second))
