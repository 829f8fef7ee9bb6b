from dataclasses import replace

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


@pytest.mark.parametrize("kernel", KERNELS[:2], ids=lambda k: type(k).__name__)
@pytest.mark.parametrize("nodes", [2, 120, 30_000])
def test_compiled_rows_give_the_same_minima(kernel, nodes):
    problem = reduce(scattered(nodes, kernel=kernel))
    y = problem.pack(np.random.default_rng(0).random(nodes))
    rows = parents.AffineRows.of(problem)
    assert np.array_equal(rows(y), problem.parent_values(y))
    some = replace(rows, moving=np.flatnonzero(np.random.default_rng(1).random(problem.n_rows) < 0.5))
    assert np.array_equal(some(y), problem.parent_values(y)[some.rows])


def test_an_own_kernel_is_called_with_all_arcs():
    problem = reduce(scattered(120, kernel=KERNELS[2]))
    y = problem.pack(np.random.default_rng(0).random(120))
    rows = parents.parents_of(problem)
    assert isinstance(rows, parents.AllRows)
    assert np.array_equal(rows(y), problem.parent_values(y))


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda k: type(k).__name__)
@pytest.mark.parametrize("start", [None, 0.0, "mixed"])
def test_large_problems_settle_like_small_ones(monkeypatch, kernel, start):
    net = scattered(150, seed=1, kernel=kernel)
    x0 = np.random.default_rng(5).random(150) * 0.9 if start == "mixed" else start
    small = solve(net, x0=x0, save=gabf.EverySteps(1))
    monkeypatch.setattr(parents, "FEWER_ROWS_FROM", 0)
    monkeypatch.setattr(splitting, "RETIRE_EVERY", 1)
    large = solve(net, x0=x0, save=gabf.EverySteps(1))
    assert np.array_equal(small.x, large.x)
    assert small.settling_tau == pytest.approx(large.settling_tau, rel=1e-9)
    assert small.steps == large.steps
    finite = np.isfinite(small.x)
    assert np.allclose(small.trajectory.x[:, finite], large.trajectory.x[:, finite], rtol=1e-9, atol=1e-12)


def test_rows_are_retired_as_the_wave_passes(monkeypatch):
    monkeypatch.setattr(parents, "FEWER_ROWS_FROM", 0)
    problem = reduce(scattered(300, seed=1))
    rows = parents.AffineRows.of(problem)
    x_star = problem.pack(gabf.oracle(problem.network))
    y = x_star + np.where(x_star > np.median(x_star), 1.0, 0.0)
    xhat = y[: problem.n_rows] - problem.parent_values(y)
    fewer = rows.retire(y, xhat, rows.lowest_moving(y, xhat))
    assert fewer.rows.size < 0.75 * problem.n_rows
    assert np.array_equal(fewer(y), problem.parent_values(y)[fewer.rows])
    retired = np.setdiff1d(np.arange(problem.n_rows), fewer.rows)
    assert np.array_equal(y[retired], x_star[retired])


def test_a_row_at_rest_is_kept_while_its_parent_may_move(monkeypatch):
    """Costs that vanish in rounding let a moving parent and a resting row have the same value."""
    monkeypatch.setattr(parents, "FEWER_ROWS_FROM", 0)
    net = from_arcs(3, [(1, 0, 2e9), (2, 1, 1e-9)])
    rows = parents.AffineRows.of(reduce(net))
    y = np.array([1e9, 1e9, 0.0])
    xhat = y[:2] - reduce(net).parent_values(y)
    assert xhat.tolist() == [-1e9, 0.0]
    assert rows.retire(y, xhat, rows.lowest_moving(y, xhat)).moving.tolist() == [0, 1]


def test_both_ways_of_reversing_the_graph_count_the_same_hops(monkeypatch):
    net = scattered(200, seed=5, degree=2)
    swept = reachability.hops_to_source(net)
    monkeypatch.setattr(reachability, "SWEEP_BELOW", 0)
    assert np.array_equal(reachability.hops_to_source(net), swept)
    assert swept.min() == -1
    assert swept.max() > 3
