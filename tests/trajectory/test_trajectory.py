"""Pieces through points: SciPy's interpolators agree, extrema are those of dense samples, velocities integrate."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BPoly, CubicHermiteSpline

from planner.base.errors import ArrayError
from planner.trajectory.trajectory import Trajectory

JOINTS = ("a", "b", "c")
RNG = np.random.default_rng(3)
TIMES = np.concatenate([[0.0], np.cumsum(RNG.uniform(0.05, 1.0, size=7))]).round(9)  # of a clock of nanoseconds
Q, QD, QDD = RNG.normal(size=(3, 8, 3))
MOST = np.array([1.0, 0.3, 2.0])
T = np.linspace(0.0, TIMES[-1], 4001)


CUBICS = CubicHermiteSpline(TIMES, Q, QD)
QUINTICS = BPoly.from_derivatives(TIMES, np.stack([Q, QD, QDD], axis=1))


def by_numpy(t: np.ndarray, order: int) -> np.ndarray:
    return np.stack([np.interp(t, TIMES, column) for column in Q.T], axis=1)


@pytest.mark.parametrize(
    ("kind", "given", "judge", "orders"),
    [("lines", (Q,), by_numpy, 1), ("cubics", (Q, QD), CUBICS, 4), ("quintics", (Q, QD, QDD), QUINTICS, 3)],
)
def test_pieces_are_those_of_scipy(kind: str, given: Any, judge: Any, orders: int) -> None:
    found = Trajectory.from_points(JOINTS, TIMES, *given)
    assert found.interpolation == kind
    for order in range(orders):
        np.testing.assert_allclose(found.at(T, order), judge(T, order), atol=1e-7)
    for order, column in enumerate(given):
        np.testing.assert_allclose(found.knots(order), column, atol=1e-9)


@pytest.mark.parametrize("given", [(Q,), (Q, QD), (Q, QD, QDD)])
def test_extrema_are_those_of_dense_samples(given: Any) -> None:
    found = Trajectory.from_points(JOINTS, TIMES, *given)
    for order in range(3):
        low, high = found.extrema(order)
        values = found.at(T, order)
        piece = np.minimum(np.searchsorted(TIMES, T, side="right") - 1, len(TIMES) - 2)
        for k in range(len(TIMES) - 1):
            inside = values[piece == k]
            size = 1e-9 + 0.02 * np.ptp(inside, axis=0) + 1e-9 * np.abs(inside).max()
            assert (inside.min(axis=0) >= low[k] - 1e-9).all()
            assert (inside.max(axis=0) <= high[k] + 1e-9).all()
            assert (inside.min(axis=0) <= low[k] + size + 0.05).all() or len(inside) < 50
            np.testing.assert_allclose(found.largest(order)[k], np.maximum(-low[k], high[k]))
        share, piece, joint = found.worst(order, MOST)
        assert share == pytest.approx((found.largest(order) / MOST).max(), rel=1e-12)
        assert share == pytest.approx(found.largest(order)[piece, joint] / MOST[joint], rel=1e-12)


def test_before_and_after_it_stands_still() -> None:
    found = Trajectory.from_points(JOINTS, TIMES, Q, QD)
    np.testing.assert_allclose(found.at(np.array([-1.0, TIMES[-1] + 1.0])), Q[[0, -1]])
    assert found.duration == TIMES[-1]


@pytest.mark.parametrize("order", [4, 400, 10**18])
def test_derivatives_beyond_the_degree_are_zero(order: int) -> None:
    short = Trajectory.from_points(("a",), np.array([0.0, 0.01]), np.array([[0.0], [1.0]]), np.zeros((2, 1)))
    for values in (short.at(0.005, order), short.knots(order), *short.ends(order), *short.extrema(order)):
        np.testing.assert_array_equal(values, 0.0)


@pytest.mark.parametrize("given", [(Q,), (Q, QD), (Q, QD, QDD)])
@pytest.mark.parametrize("dt", [0.01, 0.0013])
def test_samples_are_derivatives_of_each_other(given: Any, dt: float) -> None:
    """Central differences of one column are the next, within dt²/6 of the largest third derivative, off the knots."""
    motion = Trajectory.from_points(JOINTS, TIMES, *given)
    found = motion.sample(dt)
    assert (found.times[0], found.times[-1]) == (TIMES[0], TIMES[-1])
    assert ((np.diff(found.times) > 0) & (np.diff(found.times) < 1.000001 * dt)).all()
    assert (np.diff(found.times)[:-1] > 0.999999 * dt).all()
    columns = (found.positions, found.velocities, found.accelerations, found.jerks)
    piece = np.searchsorted(TIMES, found.times, side="right")
    inside = (piece[2:-1] == piece[:-3]).nonzero()[0]  # the last step is shorter
    for order, (rows, slopes) in enumerate(itertools.pairwise(columns)):
        np.testing.assert_array_equal(rows, motion.at(found.times, order))
        slope = (rows[2:-1] - rows[:-3]) / (found.times[2:-1] - found.times[:-3])[:, None]
        most = dt**2 / 6 * motion.largest(order + 3).max() + 1e-9 / dt
        np.testing.assert_allclose(slope[inside], slopes[1:-2][inside], atol=most)


def test_a_step_that_ends_where_the_motion_ends_adds_no_sample() -> None:
    motion = Trajectory.from_points(("a",), np.array([0.0, 0.7]), np.zeros((2, 1)))
    for dt, count in ((0.1, 8), (0.7, 2), (5.0, 2), (0.3, 4)):
        assert len(motion.sample(dt).times) == count
    for dt in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ArrayError, match="dt must be above 0 s"):
            motion.sample(dt)


def test_samples_as_a_table() -> None:
    pandas = pytest.importorskip("pandas")
    found = Trajectory.from_points(JOINTS, TIMES, Q, QD).sample(0.1)
    table = found.to_pandas()
    assert isinstance(table, pandas.DataFrame)
    assert list(table.columns) == [
        "time",
        *(f"{kind}_{name}" for kind in ("q", "qd", "qdd", "qddd") for name in JOINTS),
    ]
    np.testing.assert_array_equal(table["time"], found.times)
    np.testing.assert_array_equal(table[["qddd_a", "qddd_b", "qddd_c"]], found.jerks)
