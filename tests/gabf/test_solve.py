"""Runs: where they end, when they settled, and what is kept of them."""

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import AssumptionError, OptionError
from planner.gabf.problem import reduce_network
from planner.gabf.solve import require_roots

from .networks import from_arcs, scattered, solve

NET = scattered(200, seed=4)


def test_a_small_residual_is_not_taken_for_convergence():
    """Two nodes linked by one arc of 0.002 and far from the source: from zeros they rise together, slowly."""
    net = from_arcs(3, [(1, 2, 0.002), (2, 1, 0.002), (1, 0, 0.5)])
    result = solve(net, x0=0.0, save_every=1)
    assert result.x.tolist() == [0.0, 0.5, 0.502]
    early = result.history.x[1]
    assert np.abs(gabf.bellman_operator(net, early) - early).max() < 0.005
    assert gabf.max_error(early, gabf.oracle(net)) > 0.4


def test_budgets_end_a_run():
    result = solve(NET, max_steps=4)
    assert (result.steps, result.outcome) == (3, gabf.Ending.BUDGET_SPENT)
    assert (result.settling_tau, result.settling_time, result.log10_remaining) == (None, None, None)
    assert solve(NET, until_tau=2.5).end_tau == 2.5
    assert solve(NET, max_steps=0).steps == 0
    with pytest.raises(OptionError, match="must be positive"):
        solve(NET, settle_tolerance=0)
    with pytest.raises(OptionError, match="at least 0"):
        solve(NET, max_steps=-1)


def test_weights_of_1e9_beside_weights_of_1e_minus_9():
    net = from_arcs(4, [(1, 0, 1e9), (2, 1, 1e-9), (1, 2, 1e-9), (3, 2, 1e-9)])
    result = solve(net)
    assert np.array_equal(result.x, gabf.oracle(net))
    assert gabf.extract_path(net, result, 3).tolist() == [3, 2, 1, 0]
    with pytest.raises(AssumptionError, match="stuck at 5e\\+08: an arc cost on its path vanishes"):
        solve(net, x0=5e8)


def test_a_history_keeps_the_start_every_so_manieth_state_and_the_end():
    assert solve(NET).history is None
    result = solve(NET, save_every=1)
    saved = result.history
    assert len(saved.tau) == result.steps + 1
    assert np.array_equal(saved.x[0], result.x0)
    assert np.array_equal(saved.x[-1], result.x)
    thin = solve(NET, save_every=4).history
    assert len(thin.tau) == (result.steps + 3) // 4 + 1
    assert np.array_equal(thin.x[[1, -1]], saved.x[[4, -1]])
    away = ~np.isfinite(result.x)
    assert np.isinf(saved.x[:, away]).all()
    assert (saved.u[:, away] == 0).all()
    assert (saved.u[:, NET.sources] == 0).all()


def test_a_run_that_is_cut_is_at_the_reading_asked_for_and_ends_where_the_whole_one_does():
    cut = solve(NET, until_tau=0.7)
    assert cut.end_tau == 0.7
    assert np.array_equal(solve(NET, x0=np.nan_to_num(cut.x, posinf=0.0)).x, solve(NET).x)


def test_settling_time_is_the_first_after_which_all_errors_stay_in_the_band():
    x_star = gabf.oracle(NET)
    for law in (gabf.SingularityFree(), gabf.Nominal()):
        for tolerance in (1e-2, 1e-9):
            result = solve(NET, law, save_every=1, settle_tolerance=tolerance)
            saved, finite = result.history, np.isfinite(x_star)
            error = np.abs(saved.x - x_star)[:, finite] / np.maximum(1, x_star[finite])
            inside = error.max(axis=1) <= tolerance
            last_outside = np.flatnonzero(~inside)[-1]
            assert saved.tau[last_outside] < result.settling_tau <= saved.tau[last_outside + 1]


def test_settling_time_converges_with_the_tolerance():
    tau = [solve(NET, solver=gabf.Splitting(tol)).settling_tau for tol in (0.05, 0.02, 0.005, 0.0005)]
    errors = np.abs(np.array(tau[:-1]) / tau[-1] - 1)
    assert errors[0] < 0.1
    assert errors[2] < 0.01
    assert errors[2] < errors[1] < errors[0]


def test_a_residual_of_zero_without_a_root_is_no_solution():
    """Two nodes that hold each other at a value beside which the cost of an arc vanishes."""
    net = from_arcs(3, [(1, 0, 1.0), (1, 2, 1e-9), (2, 1, 1e-9)])
    problem = reduce_network(net)
    require_roots(problem, problem.pack(gabf.oracle(net)))
    with pytest.raises(AssumptionError, match="stuck at -1e\\+10"):
        require_roots(problem, problem.pack(np.array([0.0, -1e10, -1e10])))
