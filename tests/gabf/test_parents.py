import numpy as np
import pytest

from planner import gabf
from planner.gabf import parents, splitting
from planner.gabf.problem import reduce

from .networks import from_arcs, scattered, solve

KERNELS = [
    gabf.TradeOff(0.5),
    gabf.Multiplicative(K=20.0),
    gabf.UserKernel(lambda i, a, b: a + b + 0.1 * (i % 3)),
]


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda k: type(k).__name__)
def test_parent_values_are_the_least_over_the_arcs(kernel):
    problem = reduce(scattered(120, kernel=kernel))
    y = problem.pack(np.random.default_rng(0).random(120))
    assert np.array_equal(parents.parents_of(problem)(y), problem.parent_values(y))


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda k: type(k).__name__)
@pytest.mark.parametrize("start", [None, 0.0, "mixed"])
def test_retiring_rows_changes_nothing(monkeypatch, kernel, start):
    net = scattered(150, seed=1, kernel=kernel)
    x0 = np.random.default_rng(5).random(150) * 0.9 if start == "mixed" else start
    runs = []
    for every in (10**9, 1):
        monkeypatch.setattr(splitting, "RETIRE_EVERY", every)
        runs.append(solve(net, x0=x0, save=gabf.EverySteps(1)))
    never, always = runs
    assert np.array_equal(never.x, always.x)
    assert never.settling_tau == always.settling_tau
    assert np.array_equal(never.history.x, always.history.x)


@pytest.mark.parametrize("kernel", KERNELS[::2], ids=lambda k: type(k).__name__)
def test_rows_are_retired_as_the_wave_passes(kernel):
    problem = reduce(scattered(300, seed=1, kernel=kernel))
    every = parents.parents_of(problem)
    x_star = problem.pack(gabf.oracle(problem.network))
    y = x_star + np.where(x_star > np.median(x_star), 1.0, 0.0)
    at = problem.standing(y)
    fewer = every.retire(at, at.lowest_moving)
    assert fewer.rows is not None
    assert fewer.rows.size < 0.75 * problem.n_rows
    assert np.array_equal(fewer(y), problem.parent_values(y)[fewer.rows])
    retired = np.setdiff1d(np.arange(problem.n_rows), fewer.rows)
    assert np.array_equal(y[retired], x_star[retired])
    y[:-1] -= np.where(x_star[:-1] < np.quantile(x_star, 0.9), y[:-1] - x_star[:-1], 0.0)
    at = problem.standing(y)
    fewest = fewer.retire(at, at.lowest_moving)
    assert fewest.rows is not None
    assert fewest.rows.size < fewer.rows.size
    assert np.array_equal(fewest(y), problem.parent_values(y)[fewest.rows])


def test_a_row_at_rest_is_kept_while_its_parent_may_move():
    """Costs that vanish in rounding let a moving parent and a resting row have the same value."""
    net = from_arcs(3, [(1, 0, 2e9), (2, 1, 1e-9)])
    every = parents.parents_of(reduce(net))
    y = np.array([1e9, 1e9, 0.0])
    at = reduce(net).standing(y)
    assert at.xhat.tolist() == [-1e9, 0.0]
    assert every.retire(at, at.lowest_moving) is every


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda k: type(k).__name__)
@pytest.mark.parametrize("some", [False, True])
def test_a_step_in_one_call_is_its_parts(kernel, some):
    """And so is what is said of where it ends, for all rows and for those that are left."""
    problem = reduce(scattered(300, seed=1, kernel=kernel))
    every = parents.parents_of(problem)
    y = problem.pack(np.random.default_rng(0).uniform(0, 3, 300))
    kept = np.arange(problem.n_rows) % 3 > 0
    looked_at = every.of(np.flatnonzero(kept), kept) if some else every
    flow, rows = gabf.SingularityFree().flow, looked_at.where
    at = looked_at.standing(y)
    assert np.array_equal(at.xhat[rows], (y[: problem.n_rows] - problem.parent_values(y))[rows])
    following, off = looked_at.step(flow, at, 0.1, 1.0)
    middle = y.copy()
    flow.compiled.sketch(looked_at.rows, y, at.xhat, flow.half_step(0.1, 1.0), middle)
    expected = middle.copy()
    m = problem.parent_values(middle)[rows]
    assert off == flow.compiled.advance(looked_at.rows, m, y, at.xhat, 0.1, 1.0, expected)
    assert np.array_equal(following.y, expected)
    xhat = np.zeros(problem.n_rows)
    xhat[rows] = (expected[: problem.n_rows] - problem.parent_values(expected))[rows]
    own = expected[: problem.n_rows]
    assert np.array_equal(following.xhat, xhat)
    least = np.minimum(own, own - xhat)[xhat != 0].min()
    assert following[2:5] == (np.abs(xhat).max(), own.min(), own.max())
    assert following.lowest_moving == pytest.approx(least, rel=1e-15)
