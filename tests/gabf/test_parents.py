import numpy as np
import pytest

from planner import gabf
from planner.gabf import parents, reachability, splitting
from planner.gabf.problem import reduce

from .networks import from_arcs, scattered, solve

KERNELS = [
    gabf.TradeOff(0.5),
    gabf.Multiplicative(K=20.0),
    gabf.UserKernel(lambda i, a, b: a + b + 0.1 * (i % 3)),
]


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda k: type(k).__name__)
def test_grouped_rows_give_the_same_minima(kernel):
    problem = reduce(scattered(120, kernel=kernel))
    y = problem.pack(np.random.default_rng(0).random(120))
    grouped = parents.by_degree(problem)
    assert np.array_equal(np.sort(grouped.rows), np.arange(problem.n_rows))
    assert np.array_equal(grouped(y), problem.parent_values(y)[grouped.rows])


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda k: type(k).__name__)
@pytest.mark.parametrize("start", [None, 0.0, "mixed"])
def test_large_problems_settle_like_small_ones(monkeypatch, kernel, start):
    net = scattered(150, seed=1, kernel=kernel)
    x0 = np.random.default_rng(5).random(150) * 0.9 if start == "mixed" else start
    small = solve(net, x0=x0, save=gabf.EverySteps(1))
    monkeypatch.setattr(parents, "GROUP_FROM", 0)
    monkeypatch.setattr(splitting, "RETIRE_EVERY", 1)
    large = solve(net, x0=x0, save=gabf.EverySteps(1))
    assert np.array_equal(small.x, large.x)
    assert small.settling_tau == pytest.approx(large.settling_tau, rel=1e-9)
    assert small.steps == large.steps
    finite = np.isfinite(small.x)
    assert np.allclose(small.trajectory.x[:, finite], large.trajectory.x[:, finite], rtol=1e-9, atol=1e-12)


def test_rows_are_retired_as_the_wave_passes():
    problem = reduce(scattered(300, seed=1))
    grouped = parents.by_degree(problem)
    x_star = problem.pack(gabf.oracle(problem.network))
    y = x_star + np.where(x_star > np.median(x_star), 1.0, 0.0)
    xhat = y[: problem.n_rows] - problem.parent_values(y)
    fewer = grouped.retire(y, xhat, grouped.lowest_moving(y, xhat))
    assert fewer.rows.size < 0.75 * problem.n_rows
    assert np.array_equal(fewer(y), problem.parent_values(y)[fewer.rows])
    retired = np.setdiff1d(np.arange(problem.n_rows), fewer.rows)
    assert np.array_equal(y[retired], x_star[retired])


def test_a_row_at_rest_is_kept_while_its_parent_may_move():
    """Costs that vanish in rounding let a moving parent and a resting row have the same value."""
    net = from_arcs(3, [(1, 0, 2e9), (2, 1, 1e-9)])
    grouped = parents.by_degree(reduce(net))
    y = np.array([1e9, 1e9, 0.0])
    xhat = y[:2] - reduce(net).parent_values(y)
    assert xhat.tolist() == [-1e9, 0.0]
    assert sorted(grouped.retire(y, xhat, grouped.lowest_moving(y, xhat)).rows) == [0, 1]


@pytest.mark.parametrize("kernel", KERNELS[:2], ids=lambda k: type(k).__name__)
def test_padded_rows_give_the_same_minima(kernel):
    problem = reduce(scattered(120, kernel=kernel))
    y = problem.pack(np.random.default_rng(0).random(120))
    rows = parents.padded(problem)
    assert rows is not None
    assert np.array_equal(rows(y), problem.parent_values(y))


def test_rows_are_not_padded_where_one_of_them_is_far_longer():
    star = from_arcs(60, [(1, k, 1.0) for k in range(2, 60)] + [(k, 0, 1.0) for k in range(2, 60)])
    assert parents.padded(reduce(star)) is None
    assert solve(star).x.tolist() == [0.0, 2.0, *[1.0] * 58]
    assert parents.padded(reduce(scattered(30, kernel=KERNELS[2]))) is None


def test_both_ways_of_reversing_the_graph_count_the_same_hops(monkeypatch):
    net = scattered(200, seed=5, degree=2)
    swept = reachability.hops_to_source(net)
    monkeypatch.setattr(reachability, "SWEEP_BELOW", 0)
    assert np.array_equal(reachability.hops_to_source(net), swept)
    assert swept.min() == -1
    assert swept.max() > 3
