"""Refined paths: cheaper, proven, above floors."""

from functools import lru_cache

import numpy as np
import pytest

from planner.collision.edge_prover import EdgeProver
from planner.cost.motion_cost import MotionCost
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.problem.request import Objective
from planner.roadmap.refine import TOLERANCE, PathRefiner, simplify, split_evenly
from planner.trajectory.measure import count_corners, path_contact, path_manipulability
from tests.worlds import checker_of, load, small_plan


@lru_cache
def unrefined() -> Plan:
    return plan(request=small_plan().request.with_options(refinement_rounds=0), timing=None)


@pytest.mark.parametrize("beta", [0.0, 0.5, 1.0])
def test_rounds_make_a_path_cheaper_and_keep_its_motions_proven(beta: float) -> None:
    made = unrefined()
    refiner = PathRefiner(EdgeProver(made.checker), MotionCost(made.robot, made.roadmap.scale, Objective(beta)))
    path = split_evenly(made.path, 1.0)
    refined = refiner.finish(refiner.round(refiner.round(path)))
    np.testing.assert_array_equal(refined[[0, -1]], path[[0, -1]])
    assert refiner.total(refined) < refiner.total(path)
    assert EdgeProver(made.checker).prove(refined[:-1], np.diff(refined, axis=0)).free.all()
    assert path_contact(made.checker, refined) is None
    assert ((refined >= made.robot.lower) & (refined <= made.robot.upper)).all()


def test_in_open_space_a_detour_becomes_the_straight_motion() -> None:
    checker = checker_of("planar_2r")
    refiner = PathRefiner(
        EdgeProver(checker), MotionCost(load("planar_2r"), small_plan().roadmap.scale, Objective(1.0))
    )
    bent = np.array([[0.0, 0.5], [0.6, 1.8], [-0.3, 0.9], [1.0, 1.0]])
    np.testing.assert_array_equal(refiner.round(bent), bent[[0, -1]])


def test_a_floor_holds() -> None:
    made = unrefined()
    inner = made.path[1:-1]
    floor = 0.8 * path_manipulability(made.robot, inner).min()
    cost = MotionCost(made.robot, made.roadmap.scale, Objective(1.0, floor=floor))
    refined = PathRefiner(EdgeProver(made.checker), cost).round(inner)
    assert path_manipulability(made.robot, refined).min() >= floor


@pytest.mark.parametrize(("beta", "fewer"), [(0.0, 2), (1.0, 1)])
def test_corners_become_fewer_at_a_bounded_price(beta: float, fewer: int) -> None:
    made = unrefined()
    refiner = PathRefiner(EdgeProver(made.checker), MotionCost(made.robot, made.roadmap.scale, Objective(beta)))
    path = refiner.descend(split_evenly(made.path, 0.5))
    simple = simplify(refiner, path, np.random.default_rng(0))
    np.testing.assert_array_equal(simple[[0, -1]], path[[0, -1]])
    assert count_corners(simple) <= count_corners(path) - fewer
    assert refiner.total(simple) <= (1.0 + TOLERANCE) * refiner.total(path)
    assert EdgeProver(made.checker).prove(simple[:-1], np.diff(simple, axis=0)).free.all()
    assert path_contact(made.checker, simple) is None


def test_a_path_below_the_floor_stays_as_it_is() -> None:
    """Its cost is infinite: no merger keeps to a share of that, and none was to be taken for all of them."""
    made = unrefined()
    path = split_evenly(made.path, 0.5)
    cost = MotionCost(made.robot, made.roadmap.scale, Objective(0.5))
    least = path_manipulability(made.robot, path).min()
    refiner = PathRefiner(EdgeProver(made.checker), cost.above(1.1 * float(least)))
    assert len(path) > 3
    assert np.isinf(refiner.total(path))
    with np.errstate(all="raise"):
        np.testing.assert_array_equal(simplify(refiner, path, np.random.default_rng(0)), path)
