"""Bridges between two parts of a roadmap: short, proven, and the same for the same seed."""

from __future__ import annotations

import numpy as np
import pytest

from planner.base.progress import Progress
from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver
from planner.collision.looks import recheck
from planner.roadmap.bridges import bridges
from planner.roadmap.growth_settings import GrowthSettings
from planner.robot.poses import pose
from planner.robot.shapes import Box
from tests.worlds import checker_of, load, make_post, post_roadmap, random_q, scene_of

LEFT, RIGHT = (post_roadmap().nodes[post_roadmap().nodes[:, 0] * side > 0.8] for side in (-1, 1))  # of the post


def assert_bridge(path: np.ndarray, part: np.ndarray, other: np.ndarray, prover: EdgeProver) -> None:
    assert (part == path[0]).all(axis=1).any()
    assert (other == path[-1]).all(axis=1).any()
    delta = prover.robot.difference(path[:-1], path[1:])
    assert np.linalg.norm(delta, axis=1).max() <= GrowthSettings().range * (1 + 1e-9)
    assert all(recheck(prover.checker, q, d) is None for q, d in zip(path, delta, strict=False))


@pytest.mark.parametrize("sizes", [(40, 9), (9, 40), (1, 1)])
def test_where_nothing_is_in_the_way_the_nearest_pair_is_among_them(sizes: tuple[int, int]) -> None:
    prover = EdgeProver(checker_of("planar_2r"))
    part, other = (random_q(prover.robot, size, seed) for seed, size in enumerate(sizes))
    found = bridges(prover, part, other)
    apart = np.linalg.norm(part[:, None] - other[None], axis=2)
    i, k = np.unravel_index(np.argmin(apart), apart.shape)
    np.testing.assert_array_equal(found[0][[0, -1]], [part[i], other[k]])
    for path in found:
        assert_bridge(path, part, other, prover)


def test_around_an_obstacle_the_path_is_searched() -> None:
    prover = EdgeProver(make_post())
    # the straight motions between these are blocked
    part, other = LEFT[:1], RIGHT[:1]
    assert not prover.prove(part, other - part).free[0]
    (path,) = bridges(prover, part, other)
    assert len(path) > 2
    assert_bridge(path, part, other, prover)


def test_the_seed_decides() -> None:
    prover = EdgeProver(make_post())
    one, same, other = (bridges(prover, LEFT[:1], RIGHT[:1], seed)[0] for seed in (3, 3, 4))
    np.testing.assert_array_equal(one, same)
    assert one.shape != other.shape or not np.array_equal(one, other)


def test_without_a_way_there_is_none() -> None:
    """Two walls shut the second configuration in."""
    walls = [(Box((0.3, 0.02, 0.2)), pose([0.28, y, 0])) for y in (-0.12, 0.12)]
    shut = EdgeProver(make_checker(load("planar_2r"), scene_of(*walls)))
    part, other = np.array([[1.2, 0.5]]), np.array([[0.0, 0.0]])
    assert bridges(shut, part, other, settings=GrowthSettings(join_motions=300)) == []
    assert bridges(shut, part, other[:0]) == []
    assert bridges(shut, part, other, progress=Progress(stop=lambda: True)) == []
