import numpy as np
import pytest

from planner import gabf
from planner.base.errors import AssumptionError, OptionError

from .networks import Network, chain, from_arcs, scattered, solve

NET = scattered(200, seed=4)


def test_the_result_is_the_oracle_to_the_last_bit_and_proves_it():
    result = solve(NET)
    x_star = gabf.oracle(NET)
    assert np.array_equal(result.x, x_star)
    assert (result.residual, result.error_bound) == (0.0, 0.0)
    assert gabf.residual(NET, result.x) == 0.0
    assert gabf.max_error(result, x_star) == 0.0


def test_results_are_read_only_and_repeatable():
    one, two = solve(NET), solve(NET)
    assert (one.settling_tau, one.steps, one.evaluations) == (two.settling_tau, two.steps, two.evaluations)
    with pytest.raises(ValueError, match="read-only"):
        one.x[0] = 1.0


def test_a_small_residual_is_not_taken_for_convergence():
    """Two nodes linked by one arc of 0.002 and far from the source: from zeros they rise together, slowly."""
    net = from_arcs(3, [(1, 2, 0.002), (2, 1, 0.002), (1, 0, 0.5)])
    result = solve(net, x0=0.0, save=gabf.EverySteps(1))
    assert result.x.tolist() == [0.0, 0.5, 0.502]
    early = result.history.x[1]
    assert gabf.residual(net, early) < 0.005
    assert gabf.max_error(early, gabf.oracle(net)) > 0.4


def test_error_bound_holds_wherever_the_run_is_stopped():
    x_star = gabf.oracle(NET)
    proved = 0
    for tau in (1.0, 4.0, 12.0, 25.0, 35.0, 40.0, 50.0, 60.0):
        result = solve(NET, gabf.Nominal(), x0=np.full(200, 7.0), until_tau=tau)
        assert np.abs(result.x - x_star)[np.isfinite(x_star)].max() <= result.error_bound
        proved += np.isfinite(result.error_bound)
    assert proved >= 2


def test_budgets_end_a_run():
    result = solve(NET, max_steps=4)
    assert (result.steps, result.outcome) == (3, gabf.Ending.BUDGET_SPENT)
    assert result.evaluations == 1 + 4 + 3, "4 steps were tried, of which 3 were taken"
    assert (result.settling_tau, result.settling_time, result.log10_remaining) == (None, None, None)
    assert solve(NET, until_tau=2.5).end_tau == 2.5
    assert solve(NET, max_steps=0).steps == 0
    with pytest.raises(OptionError, match="must be positive"):
        solve(NET, settle_tolerance=0)
    with pytest.raises(OptionError, match="not negative"):
        solve(NET, max_steps=-1)


def test_self_stabilisation_after_an_arc_is_lost_and_another_gets_costlier():
    before = solve(NET)
    path = gabf.extract_path(NET, before, int(np.argmax(np.where(np.isfinite(before.x), before.x, -1))))
    i, j = int(path[2]), int(path[3])
    changed = NET.without_arcs(np.concatenate((NET.arcs_between(i, j), NET.arcs_between(j, i))))
    x_star = gabf.oracle(changed)
    assert not np.array_equal(x_star, before.x)
    warm = np.where(np.isfinite(before.x), before.x, 0.0)
    healed = solve(changed, x0=warm)
    assert np.array_equal(healed.x, x_star)
    assert healed.settling_time < healed.law.T
    cheap = Network(NET.indptr, NET.indices, NET.weight * 0.5, NET.sources, node_cost=NET.node_cost, kernel=NET.kernel)
    assert np.array_equal(solve(cheap, x0=warm).x, gabf.oracle(cheap))


@pytest.mark.parametrize("weight", [1e-9, 1.0, 1e9])
def test_weights_of_any_size(weight):
    net = chain(6, cost=weight)
    for start in (None, 0.0, 100.0 * weight):
        result = solve(net, x0=start)
        assert np.array_equal(result.x, gabf.oracle(net))
        assert result.settling_time < 4.0


def test_weights_of_1e9_beside_weights_of_1e_minus_9():
    net = from_arcs(4, [(1, 0, 1e9), (2, 1, 1e-9), (1, 2, 1e-9), (3, 2, 1e-9)])
    result = solve(net)
    assert np.array_equal(result.x, gabf.oracle(net))
    assert gabf.extract_path(net, result, 3).tolist() == [3, 2, 1, 0]
    with pytest.raises(AssumptionError, match="stuck at 5e\\+08: an arc cost on its path vanishes"):
        solve(net, x0=5e8)


def test_parallel_arcs_and_several_sources():
    net = from_arcs(3, [(1, 0, 5.0), (1, 0, 2.0), (1, 2, 0.5)], sources=(0, 2), source_values=[0.0, 1.0])
    assert solve(net).x.tolist() == [0.0, 1.5, 1.0]
