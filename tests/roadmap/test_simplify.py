"""Fewer corners: proven, at no more than the stated share of the cost, and where the two nearest motions would meet."""

from __future__ import annotations

import numpy as np
import pytest

from planner.collision.edge_prover import EdgeProver
from planner.cost.motion_cost import MotionCost
from planner.problem.request import Objective
from planner.roadmap.refine import PathRefiner, cut
from planner.roadmap.simplify import TOLERANCE, _meeting, simplified
from planner.trajectory.measure import corners, path_contact, path_manipulability
from tests.roadmap.test_refine import unrefined


@pytest.mark.parametrize(("beta", "fewer"), [(0.0, 2), (1.0, 1)])
def test_corners_become_fewer_at_a_bounded_price(beta: float, fewer: int) -> None:
    made = unrefined()
    refiner = PathRefiner(EdgeProver(made.checker), MotionCost(made.robot, made.roadmap.scale, Objective(beta)))
    path = refiner.descend(cut(made.path, 0.5))
    simple = simplified(refiner, path, np.random.default_rng(0))
    np.testing.assert_array_equal(simple[[0, -1]], path[[0, -1]])
    assert corners(simple) <= corners(path) - fewer
    assert refiner.total(simple) <= (1.0 + TOLERANCE) * refiner.total(path)
    assert EdgeProver(made.checker).prove(simple[:-1], np.diff(simple, axis=0)).free.all()
    assert path_contact(made.checker, simple) is None


def test_a_path_below_the_floor_stays_as_it_is() -> None:
    """Its cost is infinite: no merger keeps to a share of that, and none was to be taken for all of them."""
    made = unrefined()
    path = cut(made.path, 0.5)
    cost = MotionCost(made.robot, made.roadmap.scale, Objective(0.5))
    least = path_manipulability(made.robot, path).min()
    refiner = PathRefiner(EdgeProver(made.checker), cost.above(1.1 * float(least)))
    assert len(path) > 3
    assert np.isinf(refiner.total(path))
    with np.errstate(all="raise"):
        np.testing.assert_array_equal(simplified(refiner, path, np.random.default_rng(0)), path)


def test_lines_that_meet_do_so_in_one_point() -> None:
    rng = np.random.default_rng(1)
    a, meeting, aside = rng.normal(size=(3, 5, 4))
    b = 2.0 * meeting - a + 0.3 * aside  # blunt corners
    p, q = a + 0.9 * (meeting - a), b + 0.9 * (meeting - b)
    np.testing.assert_allclose(_meeting(a, p, q, b), meeting, atol=1e-9)
