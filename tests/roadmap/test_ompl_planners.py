"""OMPL's planners under our motion check, in spaces where the truth is known without any robot."""

import itertools

import numpy as np
import pytest

from planner.roadmap.ompl_planners import JointSpace, TreePlanners

LOWER, UPPER = np.array([-1.0, -1.0]), np.array([1.0, 1.0])
PLANE = JointSpace(LOWER, UPPER, np.array([False, False]))
RING = JointSpace(np.array([-np.pi, -1.0]), np.array([np.pi, 1.0]), np.array([True, False]))
START, GOAL = np.array([[-0.8, 0.0]]), np.array([[0.8, 0.0]])


def past_the_wall(first: np.ndarray, delta: np.ndarray) -> bool:
    """Free but for a wall at x = 0 below y = 0.6, exactly."""
    a, b = first, first + delta
    if a[0] * b[0] > 0:
        return True
    crossing = a[1] if delta[0] == 0 else a[1] - a[0] / delta[0] * delta[1]
    return bool(crossing > 0.6)


def search(check=past_the_wall, space: JointSpace = PLANE, seed: int = 0, limit: int = 20_000, **more):
    with TreePlanners(space, check, np.random.default_rng(seed), **more) as planners:
        return planners.rrt_connect(START, GOAL, 0.3, limit), planners


def test_a_path_passes_where_the_check_lets_it() -> None:
    path, planners = search()
    assert path is not None
    np.testing.assert_array_equal(path[[0, -1]], [START[0], GOAL[0]])
    assert all(past_the_wall(a, b - a) for a, b in itertools.pairwise(path))
    assert 0 < planners.accepted < planners.checked


@pytest.mark.parametrize("limit", [1, 37])
def test_it_ends_on_a_count(limit: int) -> None:
    path, planners = search(check=lambda *_: False, limit=limit)
    assert path is None
    assert limit <= planners.checked <= limit + 2


def test_a_joint_that_wraps_goes_the_shorter_way() -> None:
    """Nothing but the seam may be passed, between 2.5 and -2.5."""

    def across(first: np.ndarray, delta: np.ndarray) -> bool:
        return bool(abs(first[0]) > 2.5 and abs(delta[0]) <= np.pi and np.cos(first[0] + delta[0]) < np.cos(2.5))

    with TreePlanners(RING, across, np.random.default_rng(0)) as planners:
        path = planners.rrt_connect(np.array([[3.0, 0.0]]), np.array([[-3.0, 0.0]]), 0.5, 20_000)
    assert path is not None
    assert all(across(a, RING.difference(a, b)) for a, b in itertools.pairwise(path))
    assert (np.abs(path[:, 0]) > 2.5).all()


def test_a_tree_has_a_parent_for_every_node_but_its_roots() -> None:
    with TreePlanners(PLANE, past_the_wall, np.random.default_rng(0)) as planners:
        tree = planners.rrt(np.concatenate([START, GOAL]), 0.3, count=50, limit=10_000)
    assert len(tree.nodes) == 52
    children = [child for _, child in tree.edges]
    assert len(children) == len(set(children)) == 50
    for parent, child in tree.edges:
        delta = tree.nodes[child] - tree.nodes[parent]
        assert np.linalg.norm(delta) <= 0.3 + 1e-12
        assert past_the_wall(tree.nodes[parent], delta)
