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

    The margin plays no part. Pairs that no joint moves against each other (the base on its table) are left out.
    """

    def __init__(self, checker: CollisionChecker) -> None:
        self._checker = checker
        self._static = ~checker.world.pair_reach.any(axis=1)

    def __call__(self, q: Floats) -> Floats:
        rotation, position = joint_placements(self._checker.chain, np.atleast_2d(q))
        bounds = self._checker.bound.coarse(rotation, position)
        bounds[:, self._static] = np.inf
        return np.array(
            [self._nearest(bound, rotation[:, k], position[:, k]) for k, bound in enumerate(bounds)], dtype=float
        )

    def _nearest(self, bound: Floats, rotation: Floats, position: Floats) -> float:
        """Exact distances in the order of their lower bounds, until no bound can beat the best."""
        best = np.inf
        for pair in np.argsort(bound, kind="stable"):
            if bound[pair] >= best:
                break
            best = min(best, max(0.0, float(self._checker.distances(rotation, position, np.array([pair]))[0])))
        return best
