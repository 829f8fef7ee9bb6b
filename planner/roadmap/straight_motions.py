"""Straight motions as tree planners check them: proven, or sampled in a few states where the proof comes later."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Bools, Floats, length
from planner.base.resolutions import PROOF, W_IN_GROWTH
from planner.collision.edge_prover import EdgeProver, MotionCheck
from planner.kinematics.manipulability import manipulability


class Motions:
    """Motion checks in one world, for one thread; counts nothing, remembers nothing.

    With a ``floor`` > 0 a motion must also keep manipulability above it, in states ``W_IN_GROWTH`` apart. What the
    world's motions keep is looked at in the same states, and proven where a motion is.
    ``room`` (m): how much a proof must leave, see :meth:`planner.collision.edge_prover.EdgeProver.prove`.
    """

    def __init__(self, prover: EdgeProver, floor: float = 0.0, room: float = PROOF) -> None:
        self.prover, self.robot, self.floor, self.room = prover, prover.robot, floor, room
        self.keeps = prover.world.keeps
        self._ends_look_free, self._is_free = prover.checker.bound.look_along(np.inf), prover.each_free(room)

    def proven(self, first: Floats, delta: Floats) -> bool:
        """Whether the motion from ``first`` by ``delta`` (dof,) is proven free as a whole."""
        looks_free = self._ends_look_free(first, delta) and self._well_conditioned(first, delta)
        return looks_free and self._is_free(first, delta)

    def shortest_way(self, path: Floats) -> Floats:
        """The states (k, dof) of a ``path`` (n, dof) of proven motions that the shortest way along it passes.

        Motions that skip others are proven, and leave ``room``; they turn no joint by half a turn, as angles of such
        ends tell another motion, the shorter one.
        """
        states = self.robot.unwound(path)
        by = states - states[:, None]
        allowed = np.triu(self.robot.told_by_ends(by), 1) | np.eye(len(path), k=1, dtype=bool)
        price = np.where(allowed, np.sqrt((by**2).sum(axis=2)), np.inf)
        allows = self._all_well_conditioned if self.floor > 0 else None
        return path[self.prover.cheapest_chain(states, price, self.room, allows)]

    def looks_free(self, step: float) -> MotionCheck:
        """A check of states between which no point moves further than ``step`` (m): quick, and no proof."""
        look = self.prover.checker.bound.look_along(step)
        if self.floor <= 0 and not self.keeps:
            return look
        return lambda first, delta: look(first, delta) and self._well_conditioned(first, delta)

    def step(self, longest: float) -> float:
        """How far (rad) trees step, ``longest`` at most: as far as a chord keeps to what is narrow."""
        return min(longest, self.keeps.stride)

    def _all_well_conditioned(self, first: Floats, delta: Floats) -> Bools:
        return np.array([self._well_conditioned(*motion) for motion in zip(first, delta, strict=True)], dtype=bool)

    def _well_conditioned(self, first: Floats, delta: Floats) -> bool:
        if self.floor <= 0 and not self.keeps:
            return True
        count = max(1, int(np.ceil(length(delta) / W_IN_GROWTH)))
        states = first + (np.arange(count + 1) / count)[:, None] * delta
        kept = bool(self.keeps.holds(states).all())
        return kept and (self.floor <= 0 or bool((manipulability(self.robot, states) >= self.floor).all()))
