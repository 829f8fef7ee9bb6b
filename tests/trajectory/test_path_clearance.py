"""The smallest clearance along a path."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from planner.collision.checker import CollisionChecker, is_free
from planner.trajectory.path_clearance import nearest_pair, slack, smallest_clearance
from tests.coal_judge import CoalWorld
from tests.worlds import checker_of, random_q

WORLDS = [("iiwa14", "paper"), ("ur5", "table"), ("planar_2r", "window")]


def free_path(checker: CollisionChecker, rows: int = 4, seed: int = 0, step: float = 0.15) -> np.ndarray:
    """A short random walk of free configurations; what lies between them may touch."""
    robot, rng = checker.robot, np.random.default_rng(seed)
    path = [next(q for q in random_q(robot, 200, seed) if is_free(checker, q))]
    while len(path) < rows:
        q = np.clip(path[-1] + rng.normal(size=robot.dof) * step, robot.lower, robot.upper)
        if is_free(checker, q):
            path.append(q)
    return np.array(path)


@pytest.mark.parametrize(("robot", "scene"), WORLDS)
def test_smallest_clearance_against_coal(robot: str, scene: str) -> None:
    checker = checker_of(robot, scene)
    coal = CoalWorld(checker.world)
    moved = np.flatnonzero(checker.world.pair_reach.any(axis=1))
    for seed in range(2):
        path = free_path(checker, 3, seed)
        found = smallest_clearance(checker, path)
        assert found is not None
        a, b = path[found.segment : found.segment + 2]
        np.testing.assert_allclose(found.q, a + found.share * (b - a), atol=1e-12)
        here = coal.distances(found.q, moved)
        assert found.value == pytest.approx(max(0.0, here.min()), abs=2e-4)
        dense = np.concatenate([p + np.linspace(0, 1, 25)[:, None] * (q - p) for p, q in itertools.pairwise(path)])
        true = min(max(0.0, coal.distances(q, moved).min()) for q in dense)
        assert found.value <= true + slack(true) + 2e-4
        if found.value > 1e-3:
            pair = nearest_pair(checker, found.q)
            assert pair == checker.world.contact(int(moved[here.argmin()]))
