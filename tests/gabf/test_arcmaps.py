"""A kernel bound to arcs: its progress and its slopes, against dense samples of itself."""

import numpy as np
import pytest

from planner.base.errors import AssumptionError
from planner.gabf.arcmaps import AffineArcs, FunctionArcs

OFFSET, SLOPE = np.array([0.1, 0.4, 2.0]), np.array([1.2, 0.9, 0.5])
MAPS = {
    "additive": AffineArcs(None, OFFSET),
    "affine": AffineArcs(SLOPE, OFFSET),
    "a user's": FunctionArcs(lambda i, a, b: a + b + 0.1 * i, np.array([0, 1, 1]), OFFSET),
}


@pytest.mark.parametrize("name", MAPS)
def test_progress_and_slopes_are_those_of_dense_samples(name):
    arcs, grid = MAPS[name], np.linspace(-1.0, 2.0, 301)
    table = np.stack([arcs(np.full(3, a)) for a in grid])
    assert arcs.progress(-1.0, 2.0) == pytest.approx((table - grid[:, None]).min(axis=0), abs=1e-12)
    slopes = np.diff(table, axis=0) / np.diff(grid)[:, None]
    low, high = arcs.slopes(-1.0, 2.0)
    assert low == pytest.approx(slopes.min(axis=0), abs=1e-9)
    assert high == pytest.approx(slopes.max(axis=0), abs=1e-9)


@pytest.mark.parametrize("name", MAPS)
def test_some_arcs_are_the_same_arcs(name):
    arcs, a, chosen = MAPS[name], np.array([0.5, 0.7, 0.9]), np.array([2, 0])
    assert np.array_equal(arcs.take(chosen)(a[chosen]), arcs(a)[chosen])


def test_on_one_point_a_users_kernel_has_no_slope_to_measure():
    low, high = MAPS["a user's"].slopes(1.0, 1.0)
    assert low.tolist() == high.tolist() == [1.0, 1.0, 1.0]


def test_a_users_kernel_has_to_work_on_arrays():
    wrong = FunctionArcs(lambda i, a, b: np.zeros(1), np.array([0, 1, 1]), OFFSET)
    with pytest.raises(AssumptionError, match="one value an arc"):
        wrong(OFFSET)
