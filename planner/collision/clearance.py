"""How far a configuration is from the nearest contact: exact distances, cheap bounds deciding which are needed."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats
from planner.collision.checker import CollisionChecker
from planner.kinematics.forward import joint_placements


class Clearance:
    """Distance (m) of the nearest checked pair that some joint can move, for configurations of one world.

        clearance = Clearance(checker)
        clearance(q)                    # (n,) for q (n, dof); 0 where a pair touches, inf where no pair is checked
        clearance(q, below=0.01)        # the same where it is less, and a lower bound of 0.01 or more elsewhere

    The margin plays no part. Pairs that no joint moves against each other (the base on its table) are left out.
    """

    def __init__(self, checker: CollisionChecker) -> None:
        self._checker = checker
        self._static = ~checker.world.moving

    def __call__(self, q: Floats, below: float = np.inf) -> Floats:
        rotation, position, bounds = self._bounded(np.atleast_2d(q))
        return self._nearest(bounds, rotation, position, below)

    def smallest(self, q: Floats, below: float = np.inf) -> Floats:
        """(n,) the same where it is the smallest of q (n, dof), and less than ``below``; lower bounds elsewhere."""
        rotation, position, bounds = self._bounded(q)
        least = np.maximum(bounds.min(axis=1, initial=np.inf), 0.0)
        for k in np.argsort(least, kind="stable").tolist():
            if least[k] >= below:
                break
            at = slice(k, k + 1)
            least[k] = self._nearest(bounds[at], rotation[:, at], position[:, at], below)[0]
            below = min(below, least[k])
        return least

    def _bounded(self, q: Floats) -> tuple[Floats, Floats, Floats]:
        """The placements of the joints, and cheap lower bounds (n, pairs) on distances."""
        rotation, position = joint_placements(self._checker.chain, q)
        bounds = self._checker.bound.coarse(rotation, position)
        bounds[:, self._static] = np.inf
        return rotation, position, bounds

    def _nearest(self, bounds: Floats, rotation: Floats, position: Floats, below: float) -> Floats:
        """(n,) exact distances in the order of their lower ``bounds`` (n, pairs), until none can beat the best.

        One pair of every configuration at a time, where the next one can.
        """
        best, order = np.full(len(bounds), np.inf), np.argsort(bounds, axis=1, kind="stable")
        for pairs, least in zip(order.T, np.take_along_axis(bounds, order, axis=1).T, strict=True):
            rows = np.flatnonzero(least < np.minimum(best, below))
            if not len(rows):
                break
            found = self._checker.distances_in(rotation, position, rows, pairs[rows])
            best[rows] = np.minimum(best[rows], np.maximum(found, 0.0))
        farther = np.where(bounds >= below, bounds, np.inf).min(axis=1, initial=np.inf)
        return np.minimum(best, farther)
