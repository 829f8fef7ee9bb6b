"""Proofs in time against dense sampling in time by collision libraries that know nothing of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planner.base.polynomials import evaluate
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.collision.coal import CoalInTime
from planner.collision.in_time import TimedProver, moving_world
from planner.world.moving import KnownMotion, MovingObstacle
from planner.world.poses import pose
from planner.world.scene import Scene
from planner.world.shapes import Box, Obstacle
from tests.random_shapes import KINDS, random_shape
from tests.worlds import load

PIECES = 8


def moving(rng: np.random.Generator, kind: str) -> MovingObstacle:
    places = [[*rng.uniform(-1, 1, 2), rng.uniform(-0.05, 0.05)] for _ in range(3)]
    poses = [pose(place, rng.uniform(-2, 2, 3).tolist()) for place in places]
    return MovingObstacle("mover", random_shape(rng, kind), KnownMotion([0.0, 1.0, 2.5], poses))


def touches(checker: CollisionChecker, obstacle: MovingObstacle, q: np.ndarray, t: np.ndarray) -> bool:
    """Whether the robot touches the obstacle in any of the configurations at their times, by the checker's library."""
    known = checker
    for row, when in zip(q, t, strict=True):
        known = type(checker)(moving_world(checker.world, (obstacle.standing(when),)), known)
        if known.first_contact(row[None]) is not None:
            return True
    return False


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_proven_in_time_touches_at_no_sampled_moment(kind: str) -> None:
    rng, checker = np.random.default_rng(len(kind)), make_checker(load("planar_2r"), Scene("none"), "fcl")
    proven = touched = 0
    for _ in range(6):
        obstacle = moving(rng, kind)
        prover = TimedProver(checker, [obstacle])
        judge = CoalInTime(prover.world, prover.motions)
        coefficients = rng.uniform(-1, 1, (PIECES, 4, 2))
        spans = np.column_stack(
            [rng.uniform(0, 2.5, PIECES), rng.uniform(0.1, 1, PIECES), rng.choice([0.0, 0.1], PIECES)]
        )
        free = prover.free(coefficients, spans)
        for k in range(PIECES):
            s, (begin, takes, slack) = np.linspace(0, 1, 400), spans[k]
            q, t = evaluate(np.repeat(coefficients[k][None], 400, axis=0), s), begin + takes * s
            shift = slack * rng.uniform(-1, 1)
            if free[k]:
                assert judge.first_touch(q, t + shift) is None
                assert not touches(checker, obstacle, q[::40], t[::40] + shift)
                proven += 1
            elif slack == 0 and judge.first_touch(q, t) is not None:
                touched += 1
            else:
                assert slack > 0  # what is free of a piece begun on time is proven
    assert proven > 5
    assert touched > 1


def test_coal_in_time_agrees_with_fcl_at_single_moments() -> None:
    rng, checker = np.random.default_rng(4), make_checker(load("planar_2r"), Scene("none"), "fcl")
    obstacle, verdicts = replace(moving(rng, "box"), shape=Box((0.5, 0.4, 0.2))), []
    prover = TimedProver(checker, [obstacle])
    judge = CoalInTime(prover.world, prover.motions)
    for q, t in zip(rng.uniform(-3, 3, (150, 2)), rng.uniform(0, 3, 150), strict=True):
        found = judge.first_touch(q[None], np.array([t]))
        assert (found is not None) == touches(checker, obstacle, q[None], np.array([t]))
        verdicts.append(found is not None)
        if found is not None:
            assert found[1].second == "mover"
    assert 5 < sum(verdicts) < 145


def test_the_margin_is_kept_and_permissions_hold() -> None:
    cart = MovingObstacle("cart", Box((0.1, 0.1, 0.1)), KnownMotion([0, 1], [pose([1.3, 0, 0]), pose([1.3, 1, 0])]))
    still, span = np.zeros((1, 2, 2)), np.array([[0.0, 1.0, 0.0]])
    gap = 1.25 - np.abs(TimedProver(make_checker(load("planar_2r"), Scene("none")), [cart]).gaps(np.zeros(2)).min())
    for margin, free in ((0.0, True), (0.5 * (1.25 - gap), True), (1.25 - gap + 0.01, False)):
        checker = make_checker(load("planar_2r"), Scene("none"), margin=margin)
        assert TimedProver(checker, [cart]).free(still, span)[0] == free
    links = {body.link for body in load("planar_2r").bodies}
    allowed = Scene("allowed", allowed=frozenset(frozenset((link, "cart")) for link in links))
    inside = MovingObstacle("cart", cart.shape, KnownMotion([0], [pose([0.5, 0, 0])]))
    prover = TimedProver(make_checker(load("planar_2r"), allowed), [inside])
    assert prover.free(still, span)[0]


def test_an_unknown_motion_is_kept_clear_of_as_long_as_it_cannot_have_come() -> None:
    checker = make_checker(load("planar_2r"), Scene("none"))
    dog = Obstacle("dog", Box((0.2, 0.2, 0.2)), pose([2.0, 0, 0]), speed_limit=0.5)
    prover = TimedProver(checker, limited=[dog])
    gap = prover.gaps(np.zeros(2)).min()
    still = np.zeros((2, 2, 2))
    spans = np.array([[0.0, 0.99 * gap / 0.5, 0.0], [0.0, 1.01 * gap / 0.5, 0.0]])
    np.testing.assert_array_equal(prover.free(still, spans), [True, False])
    late = np.array([[0.97 * gap / 0.5, 0.01, 0.01], [0.99 * gap / 0.5, 0.01, 0.01]])
    np.testing.assert_array_equal(prover.free(still, late), [True, False])
