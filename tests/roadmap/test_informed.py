"""Informed samples."""

import numpy as np
import pytest

from planner.collision.edge_prover import EdgeProver
from planner.cost.motion_cost import MotionCost
from planner.problem.request import Objective
from planner.roadmap.informed import LazyRoadmap, sample_informed_set
from planner.roadmap.refine import PathRefiner
from tests.worlds import POST_GOAL, POST_START, checker_of, load, make_post, post_roadmap


@pytest.mark.parametrize("turned", [0.0, 0.4])
def test_samples_lie_where_a_joint_turns_the_other_way(turned: float) -> None:
    """A path turns nearly all the way round, and the short way is among what a cheaper one may take."""
    robot, scale = load("kinova"), post_roadmap().scale
    path = np.tile(robot.home, (3, 1))
    path[:, 0], path[1, 1] = [-2.9, 0.0, 2.9], robot.home[1] + turned
    refiner = PathRefiner(EdgeProver(checker_of("kinova")), MotionCost(robot, scale, Objective(1.0)))
    rate, longest = 1.0 / scale.joint_length, np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    drawn = np.vstack(
        [sample_informed_set(refiner, path, rate, np.random.default_rng(k), 400)[-100:] for k in range(10)]
    )  # the last quarter is that of the informed set
    near = [np.linalg.norm(robot.difference(drawn, end), axis=1) for end in path[[0, -1]]]
    assert (near[0] + near[1]).max() <= longest + 1e-9
    assert (np.abs(drawn[:, 0]) > 2.9).mean() > 0.1


def test_a_path_that_is_taken_up_is_proven_once_it_is_cheapest() -> None:
    """Without its edges the roadmap has no path; one through the post is refused."""
    roadmap, prover = post_roadmap(), EdgeProver(make_post())
    refiner = PathRefiner(prover, MotionCost(load("planar_2r"), roadmap.scale, Objective(1.0)))
    graph = LazyRoadmap(refiner, roadmap.nodes, roadmap.edges[:0], roadmap.starts, roadmap.goals)
    graph.add_path(np.array([POST_START, 0.5 * (POST_START + POST_GOAL), POST_GOAL]))
    assert graph.cheapest_path() is None
    whole = LazyRoadmap(refiner, roadmap.nodes, roadmap.edges, roadmap.starts, roadmap.goals).cheapest_path()
    assert whole is not None
    graph.add_path(whole)
    np.testing.assert_array_equal(graph.cheapest_path(), whole)
