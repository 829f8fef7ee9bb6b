"""Rounded paths: continuous, in the direction of travel, on the path where the width is 0."""

import numpy as np
import pytest

from planner.base.polynomials import derivative, evaluate
from planner.trajectory.curve import corner_parabolas, round_corners

PATH = np.random.default_rng(3).normal(size=(6, 3))


@pytest.mark.parametrize("widths", [[1.0, 1.0, 1.0, 1.0], [0.3, 0.0, 1.0, 0.5], [0.0] * 4])
def test_pieces_follow_each_other_in_place_and_direction(widths: list[float]) -> None:
    curve = round_corners(PATH, np.array(widths))
    pieces = curve.coefficients
    ends, speeds = (evaluate(c, np.ones(len(pieces))) for c in (pieces, derivative(pieces)))
    begins, first = (evaluate(c, np.zeros(len(pieces))) for c in (pieces, derivative(pieces)))
    np.testing.assert_allclose(ends[:-1], begins[1:], atol=1e-12)
    np.testing.assert_allclose([begins[0], ends[-1]], PATH[[0, -1]], atol=1e-12)
    for k in range(len(pieces) - 1):
        aligned = speeds[k] @ first[k + 1] / np.linalg.norm(speeds[k]) / np.linalg.norm(first[k + 1])
        assert (aligned == pytest.approx(1.0, abs=1e-12)) == (not curve.stop[k])
    assert curve.stop.sum() == 1 + np.sum(np.array(widths) == 0)
    assert (curve.corner >= 0).sum() == np.sum(np.array(widths) > 0)


def test_a_blend_touches_both_segments_at_its_width() -> None:
    (start, slope, bend), path = corner_parabolas(PATH[:3], np.array([0.4]))[0], PATH
    np.testing.assert_allclose(start, path[1] + 0.2 * (path[0] - path[1]))
    np.testing.assert_allclose(start + slope + bend, path[1] + 0.2 * (path[2] - path[1]))
    across = np.cross(slope, path[1] - path[0]), np.cross(slope + 2 * bend, path[2] - path[1])
    np.testing.assert_allclose(across, 0.0, atol=1e-12)
