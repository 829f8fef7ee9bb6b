"""The judge of the attack is right itself: formulas, coal, and its own two bounds."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest

from benchmarks.attack.cases import KINDS, random_case
from benchmarks.attack.true_distance import Placed, nearest, true_distance
from planner.models.poses import pose
from planner.models.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from tests.coal_judge import coal_distance, coal_geometry
from tests.random_shapes import box_mesh, random_pose, random_shape

TRIANGLE = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
KNOWN = [
    (Sphere(0.1), Sphere(0.2), [1, 0, 0], 0.7),
    (Box((1, 1, 1)), Sphere(0.1), [1, 1, 0.2], np.sqrt(0.5) - 0.1),
    (Box((1, 1, 1)), Box((1, 1, 1)), [1.3, 1.4, 0], 0.5),
    (Cylinder(0.3, 1.0), Cylinder(0.2, 1.0), [0.6, 0.8, 0.2], 0.5),
    (Cylinder(0.3, 1.0), Sphere(0.1), [0.7, 0, 0.8], 0.4),
    (Capsule(0.1, 1.0), Capsule(0.1, 1.0), [0, 0.3, 1.4], 0.3),
    (TRIANGLE, Sphere(0.1), [0.25, 0.25, 0.5], 0.4),
    (TRIANGLE, TRIANGLE, [0.2, 0.2, 0.3], 0.3),
    (box_mesh((1, 1, 1)), Sphere(0.1), [0, 0, 0], 0.4),
]


@pytest.mark.parametrize(("first", "second", "shift", "gap"), KNOWN)
def test_distances_that_everyone_knows(first: Shape, second: Shape, shift: list[float], gap: float) -> None:
    for seed in range(4):
        place = random_pose(np.random.default_rng(seed))
        found = true_distance((first, place), (second, place @ pose(shift)))
        assert found.low == pytest.approx(gap, abs=1e-12)
        assert found.high == pytest.approx(gap, abs=1e-12)


@pytest.mark.parametrize(("first", "second"), list(combinations_with_replacement(KINDS, 2)))
def test_coal_says_the_same_and_the_doubt_is_small(first: str, second: str) -> None:
    rng = np.random.default_rng(9)
    for k in range(20 if first == second == "mesh" else 40):
        a, b = (random_shape(rng, kind, ("normal", "thin", "large")[k % 3]) for kind in (first, second))
        p, q = random_pose(rng), random_pose(rng)
        gap = true_distance((a, p), (b, q))
        assert gap.high - gap.low < 1e-11
        assert gap.high == pytest.approx(max(0.0, coal_distance(coal_geometry(a), p, coal_geometry(b), q)), abs=1e-5)


@pytest.mark.parametrize(("first", "second"), list(combinations_with_replacement(KINDS, 2)))
def test_it_is_sure_of_the_cases_that_the_attack_draws(first: str, second: str) -> None:
    rng = np.random.default_rng(10)
    for _ in range(15):
        case = random_case((first, second), "distances", rng)
        gap = true_distance((case.first, case.place_first), (case.second, case.place_second))
        assert gap.high >= 0.0
        assert gap.low == pytest.approx(gap.high, abs=1e-8)


def test_touching_is_zero_and_groups_have_their_nearest() -> None:
    assert true_distance((Sphere(0.1), np.eye(4)), (Box((1, 1, 1)), np.eye(4))).high == 0.0
    balls: list[Placed] = [(Sphere(0.1), pose([x, 0, 0])) for x in (1.0, 2.0, -0.5)]
    assert nearest(balls, [(Sphere(0.1), np.eye(4))]).high == pytest.approx(0.3)
