"""What a plane proves is never more than the truth, and nearly all of it."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest

from planner.collision.separating_plane import core_of, core_of_points, proven_gap
from planner.studies.bench_attack.true_distance import true_distance
from planner.world.poses import pose
from planner.world.shapes import Capsule, Cylinder, Sphere
from tests.random_shapes import PRIMITIVES, random_pose, random_shape

REGIMES = ("normal", "thin", "large")


@pytest.mark.parametrize(("first", "second"), list(combinations_with_replacement(PRIMITIVES, 2)))
@pytest.mark.parametrize("share", [0.0, 0.05])
def test_both_bounds_hold_and_are_close(first: str, second: str, share: float) -> None:
    rng, apart = np.random.default_rng(7), 0
    for _ in range(60):
        a, b = (random_shape(rng, kind, REGIMES[int(rng.integers(3))]) for kind in (first, second))
        p, q = random_pose(rng), random_pose(rng)
        guess = rng.normal(size=3) if rng.random() < 0.5 else q[:3, 3] - p[:3, 3]
        gap = proven_gap(core_of((a, p[:3, :3], p[:3, 3])), core_of((b, q[:3, :3], q[:3, 3])), guess, share)
        true = true_distance((a, p), (b, q))
        assert gap.low <= true.high + 1e-12
        assert gap.high >= true.low - 1e-12
        assert true.low - gap.low <= max(2e-6, 1.01 * share * true.low)
        apart += true.low > 0.0
    assert apart > 10


def test_a_good_guess_is_proven_in_one_round() -> None:
    asked = []
    ball, other = core_of((Sphere(0.1), np.eye(3), np.zeros(3))), core_of_points(np.array([[1.0, 0.2, 0.0]]))
    counted = type(other)(lambda direction: asked.append(direction) or other.farthest(direction))
    way = np.array([1.0, 0.2, 0.0])
    gap = proven_gap(ball, counted, way, high=float(np.linalg.norm(way)) - 0.1)
    assert gap.low == pytest.approx(np.linalg.norm(way) - 0.1, abs=1e-12)
    assert len(asked) == 1
    assert proven_gap(ball, other, -way).low == pytest.approx(gap.low, abs=1e-12)  # the guess may point back


def test_a_cylinder_seen_along_its_axis_ends_at_its_cap() -> None:
    """The part of a direction across the axis is rounding there: it must not carry the point off the cap's plane."""
    for seed in range(50):
        place = random_pose(np.random.default_rng(seed))
        turn = place[:3, :3]
        point = core_of((Cylinder(0.7, 0.8), turn, np.zeros(3))).farthest(turn[:, 2])
        assert point @ turn[:, 2] == pytest.approx(0.4, abs=1e-12)
        assert np.linalg.norm(point) <= np.hypot(0.7, 0.4) + 1e-12


@pytest.mark.parametrize("shape", [Sphere(0.1), Cylinder(0.1, 0.3), Capsule(0.1, 0.3)])
def test_shapes_that_overlap_have_no_gap(shape: Sphere | Cylinder | Capsule) -> None:
    for x in (0.0, 0.05, 0.15):
        place = pose([x, 0.02, 0.0], rpy=[0.1, 0.2, 0.3])
        cores = core_of((shape, np.eye(3), np.zeros(3))), core_of((shape, place[:3, :3], place[:3, 3]))
        assert proven_gap(*cores, np.array([1.0, 0.0, 0.0])).low == 0.0


def test_corners_in_a_line_or_in_one_point() -> None:
    line, point = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0]]), np.tile([0.3, 0.4, 0.0], (3, 1))
    above = line + np.array([0.0, 0.0, 0.2])
    assert proven_gap(core_of_points(line), core_of_points(point), np.ones(3)).low == pytest.approx(0.4, abs=1e-9)
    assert proven_gap(core_of_points(line), core_of_points(above), np.ones(3)).low == pytest.approx(0.2)
