"""The compiled search for a path by two trees: against the checks that Python asks, one motion at a time."""

from typing import Any

import numpy as np
import pytest

from planner.collision.checker import CollisionChecker
from planner.kinematics.manipulability import tools_and_rows
from planner.problem.request import PlanRequest
from planner.query.query import make_query
from tests.worlds import checker_of, load

STEP, APART = 0.4, 0.05


def search(
    checker: CollisionChecker,
    starts: Any,
    goals: Any,
    seed: int = 0,
    limit: int = 20_000,
    longest: float = np.inf,
    floor: float = 0.0,
):
    bound, robot = checker.bound, checker.robot
    space = (robot.lower, robot.upper), robot.continuous, longest, tools_and_rows(robot), floor, 0.1
    ends = np.atleast_2d(starts), np.atleast_2d(goals)
    return bound.native.tree_path(bound.motion_bounds, *space, *ends, STEP, APART, seed, limit)


@pytest.mark.parametrize("seed", range(5))
def test_every_motion_of_a_path_looks_free_and_is_a_step(seed: int) -> None:
    query = make_query(PlanRequest.from_options(robot="iiwa14", scene="window").what)
    path, looked_at = search(query.checker, query.starts, query.goals, seed)
    assert len(path) - 1 <= looked_at
    np.testing.assert_array_equal(path[[0, -1]], [query.starts[0], query.goals[0]])
    look, delta = query.checker.bound.make_state_check(APART), np.diff(path, axis=0)
    assert np.linalg.norm(delta, axis=1).max() <= STEP * (1 + 1e-12)
    assert all(look(q, d) for q, d in zip(path, delta, strict=False))
    assert (path >= query.robot.lower).all()
    assert (path <= query.robot.upper).all()


def test_a_joint_that_wraps_goes_the_shorter_way() -> None:
    robot, checker = load("kinova"), checker_of("kinova")
    first, last = robot.home.copy(), robot.home.copy()
    first[0], last[0] = 3.0, -3.0
    found = [search(checker, first, last, seed)[0] for seed in range(3)]
    for path in found:
        apart = robot.difference(path[:-1], path[1:])
        assert np.linalg.norm(apart, axis=1).max() <= STEP * (1 + 1e-12)
        assert (np.abs(path[:, robot.continuous]) <= np.pi).all()
        look = checker.bound.make_state_check(APART)
        assert all(look(q, d) for q, d in zip(path, apart, strict=False))
