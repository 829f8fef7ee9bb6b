"""Straight motions as tree planners check them: proven, or sampled in a few states where the proof comes later."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.products import length, product
from planner.base.resolutions import PROOF, W_IN_GROWTH
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.manipulability import manipulability

if TYPE_CHECKING:
    from planner.roadmap.ompl_planners import MotionCheck

# where a motion is sampled before anything costly: most refused ones end in contact
_QUICK_LOOKS = np.array([1.0, 0.5])


@lru_cache(maxsize=1024)
def _between(count: int) -> Floats:
    """(count - 1, 1): what divides [0, 1] into ``count`` parts, points far apart first, as contacts lie in runs."""
    k = np.arange(1, max(count, 1))
    reversed_bits = sum((k >> bit & 1) << (30 - bit) for bit in range(31))
    return frozen(k[np.argsort(reversed_bits)][:, None] / max(count, 1))


class Motions:
    """Motion checks in one world; counts nothing, remembers nothing.

    With a ``floor`` > 0 a motion must also keep manipulability above it, in states ``W_IN_GROWTH`` apart.
    ``room`` (m): how much a proof must leave, see :meth:`planner.collision.edge_prover.EdgeProver.prove`.
    """

    def __init__(self, prover: EdgeProver, floor: float = 0.0, room: float = PROOF) -> None:
        self.prover, self.robot, self.floor, self.room = prover, prover.robot, floor, room
        self._bound = prover.checker.bound
        self._reach_T = np.ascontiguousarray(prover.world.reach.bodies.T)

    def proven(self, first: Floats, delta: Floats) -> bool:
        """Whether the motion from ``first`` by ``delta`` (dof,) is proven free as a whole."""
        looks_free = self._quick_look(first, delta) and self._well_conditioned(first, delta)
        return looks_free and bool(self.prover.free(first[None], delta[None], self.room)[0])

    def looks_free(self, step: float) -> MotionCheck:
        """A check of states between which no point moves further than ``step`` (m): quick, and no proof."""

        def check(first: Floats, delta: Floats) -> bool:
            if not (self._quick_look(first, delta) and self._well_conditioned(first, delta)):
                return False
            shares = _between(int(np.ceil(product(np.abs(delta), self._reach_T).max(initial=0.0) / step)))
            return not len(shares) or self._bound.looks_free(first + shares * delta)

        return check

    def _quick_look(self, first: Floats, delta: Floats) -> bool:
        return self._bound.looks_free(first + np.outer(_QUICK_LOOKS, delta))

    def _well_conditioned(self, first: Floats, delta: Floats) -> bool:
        if self.floor <= 0:
            return True
        count = max(1, int(np.ceil(length(delta) / W_IN_GROWTH)))
        states = first + (np.arange(count + 1) / count)[:, None] * delta
        return bool((manipulability(self.robot, states) >= self.floor).all())
