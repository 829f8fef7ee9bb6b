"""The problem that other planners get."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.first_motion.exchange import exchanged
from benchmarks.first_motion.runner import _add_obstacles, _pinocchio_robot
from planner.base.errors import PlannerError
from planner.collision.checker import is_free
from planner.problem.request import PlanRequest
from planner.setup.open import make_query
from tests.worlds import random_q


@pytest.mark.parametrize(("robot", "scene"), [("panda", "shelf"), ("iiwa14", "window"), ("ur5", "window")])
def test_the_problem_that_others_get_is_ours(robot: str, scene: str) -> None:
    """Pinocchio's own collision pairs on the exchanged data, against our checker, on random configurations."""
    query = make_query(PlanRequest(robot, scene, collision="coal"))
    problem = exchanged(query, 0, 1.0)
    model, geometry = _pinocchio_robot(problem)
    _add_obstacles(geometry, problem["obstacles"])
    data, found = model.createData(), geometry.createData()
    np.testing.assert_allclose(model.lowerPositionLimit, query.robot.lower)
    verdicts = []
    for q in [*random_q(query.robot, 60, 3), query.starts[0], query.goals[0]]:
        free = is_free(query.checker, q)
        assert free == (not pin.computeCollisions(model, data, geometry, found, q, True))
        verdicts.append(free)
    assert len(set(verdicts)) == 2


def test_what_others_cannot_be_told_is_refused() -> None:
    with pytest.raises(PlannerError, match="capsule or a mesh"):
        exchanged(make_query(PlanRequest(collision="coal")), 0, 1.0)
    with pytest.raises(PlannerError, match="carried shapes"):
        exchanged(make_query(PlanRequest(scene="gcs", collision="coal")), 0, 1.0)
