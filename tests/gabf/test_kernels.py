import math

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import AssumptionError, OptionError
from planner.gabf.kernels import AffineArcs, FunctionArcs
from reproduce.example import nine_node

from .networks import chain, from_arcs, solve


def value(kernel, a, **more):
    net = from_arcs(2, [(1, 0, 0.25)], kernel=kernel, source_values=[a], **more)
    return float(net.arcs(np.array([a]))[0])


def test_each_kernel_is_its_formula():
    assert value(gabf.Additive(), 2.0) == 2.25
    assert value(gabf.TradeOff(beta=0.25), 2.0, node_cost=[8.0, 5.0]) == 2.0 + 0.75 * 8.0 + 0.25 * 0.25
    assert value(gabf.EdgeIntegral(beta=0.25), 2.0, arc_cost=[8.0]) == 2.0 + 0.75 * 8.0 + 0.25 * 0.25
    assert value(gabf.Multiplicative(), 0.5) == pytest.approx(1 - (1 - 0.5) * 0.25, abs=1e-15)
    assert value(gabf.Multiplicative(K=2.0), 0.5) == pytest.approx(1 - (1 - 0.5) * (1 - 0.125), abs=1e-15)
    assert value(gabf.NodeDependent(), 2.0) == 2 * 2.0 + 0.25
    assert value(gabf.UserKernel(lambda i, a, b: a + i * b), 2.0) == 2.25


@pytest.mark.parametrize("beta", [-0.1, 1.1, np.nan])
def test_beta_outside_the_unit_interval_is_refused(beta):
    with pytest.raises(OptionError, match="beta must be"):
        gabf.TradeOff(beta)
    with pytest.raises(OptionError, match="beta must be"):
        gabf.EdgeIntegral(beta)


def test_missing_costs_are_named():
    assert isinstance(gabf.Network([0, 0, 1], [0], [1.0], [0]).kernel, gabf.Additive)
    assert gabf.Network([0, 0, 1], [0], [1.0], [0], node_cost=[1.0, 1.0]).kernel == gabf.TradeOff(0.5)
    with pytest.raises(AssumptionError, match="TradeOff kernel reads node_cost"):
        chain(3, kernel=gabf.TradeOff())
    with pytest.raises(AssumptionError, match="EdgeIntegral kernel reads arc_cost"):
        chain(3, kernel=gabf.EdgeIntegral())


def test_wbar_outside_its_range_names_the_arc():
    with pytest.raises(AssumptionError, match=r"arc \(1, 0\) has 1.5"):
        chain(2, cost=1.5, kernel=gabf.Multiplicative())
    with pytest.raises(AssumptionError, match=r"arc \(1, 0\) has -0.5"):
        chain(2, cost=3.0, kernel=gabf.Multiplicative(K=2.0))
    with pytest.raises(OptionError, match="K must be a positive number"):
        gabf.Multiplicative(K=0.0)


def check_premises(net, x0=None):
    return solve(net, x0=x0).premises


def test_zeta_and_lipschitz_on_the_data():
    net = from_arcs(3, [(1, 0, 2.0), (2, 1, 0.5)])
    assert (check_premises(net).zeta, check_premises(net).L) == (0.5, 1.0)
    net = chain(3, cost=0.5, kernel=gabf.Multiplicative())
    found = check_premises(net, x0=0.0)
    assert found.L == 0.5
    assert found.zeta == pytest.approx((1 - found.upper) * 0.5)
    found = check_premises(nine_node())
    assert found.L == 2.0
    assert found.zeta == 1.0  # 2a + |b| - a at a = 1 with |b| = 0.5 is 1.5, and 2|b| = 1


def test_a_kernel_that_is_not_progressive_names_node_and_arc():
    net = from_arcs(3, [(1, 0, 2.0), (2, 1, 0.0)])
    with pytest.raises(AssumptionError, match=r"not progressive .* 0 on arc 1, by which node 2 reads node 1"):
        solve(net)


def test_starts_outside_the_domain_name_the_node():
    net = chain(3, cost=0.5, kernel=gabf.Multiplicative())
    with pytest.raises(AssumptionError, match=r"node 1 starts at 1, outside the domain \[-inf, 1\)"):
        solve(net, x0=1.0)
    with pytest.raises(AssumptionError, match=r"node 1 starts at 0.5, outside the domain \[1, inf\]"):
        solve(nine_node(), x0=0.5)


def test_user_kernels_are_sampled_and_say_so():
    net = chain(4, kernel=gabf.UserKernel(lambda i, a, b: a + b + 0.25 * np.sin(a)))
    result = solve(net, x0=7.0)
    assert result.premises.sampled
    assert 1.2 < result.premises.L <= 1.25
    assert np.array_equal(result.x, gabf.oracle(net))
    assert any("sampled" in a.value for c in gabf.certify(net, result.law, result) for a in c.assumptions)


def test_a_user_kernel_is_sampled_where_its_slope_changes_and_no_bound_from_samples_is_called_proven():
    arcs = [(1, 0, 1.0), (1, 0, 0.125), (2, 0, 82.0), (2, 1, 0.125)]
    net = from_arcs(3, arcs, kernel=gabf.UserKernel(lambda i, a, b: a + b + 0.3 * np.tanh(a) + 0.3))
    result = solve(net, gabf.PrescribedTime(T=1, h=1, gamma=1), solver=gabf.Splitting(0.01))
    assert result.premises.upper > 100.0  # all of tanh lies in the first of 32 equal pieces
    assert 1.29 < result.premises.L <= 1.3
    certificates = gabf.certify(net, result.law, result)
    assert certificates
    assert all(certificate.holds and not certificate.proven for certificate in certificates)


def test_a_user_kernel_that_jumps_has_no_small_lipschitz_constant():
    net = chain(4, kernel=gabf.UserKernel(lambda i, a, b: a + b + (a > 1.7)))
    assert solve(net).premises.L > 1e6


def test_a_user_kernel_that_falls_is_refused():
    net = chain(4, kernel=gabf.UserKernel(lambda i, a, b: 20.0 - a))
    with pytest.raises(AssumptionError, match="does not increase"):
        solve(net, x0=0.0)


@pytest.mark.parametrize(
    ("f", "message"),
    [
        (lambda i, a, b: max(a, b) + b, r"truth value .*: it gets arrays, so use np.maximum\(a, b\) for max"),
        (lambda i, a, b: math.sqrt(a) + b, "np.maximum"),
        (lambda i, a, b: float(a[0] + b[0]), r"shape \(2,\), got shape \(\)"),
    ],
)
def test_a_user_kernel_that_is_not_vectorised_is_told_so(f, message):
    net = from_arcs(2, [(1, 0, 1.0), (1, 0, 2.0)], kernel=gabf.UserKernel(f))
    with pytest.raises(AssumptionError, match=message):
        solve(net, x0=9.0)


OFFSET, SLOPE = np.array([0.1, 0.4, 2.0]), np.array([1.2, 0.9, 0.5])
MAPS = {
    "additive": AffineArcs(None, OFFSET),
    "affine": AffineArcs(SLOPE, OFFSET),
    "a user's": FunctionArcs(lambda i, a, b: a + b + 0.1 * i, np.array([0, 1, 1]), OFFSET),
}


@pytest.mark.parametrize("name", MAPS)
def test_extremes_are_those_of_dense_samples(name):
    arcs, grid = MAPS[name], np.linspace(-1.0, 2.0, 301)
    table = np.stack([arcs(np.full(3, a)) for a in grid])
    gains, low, high = arcs.extremes(-1.0, 2.0)
    assert gains == pytest.approx((table - grid[:, None]).min(axis=0), abs=1e-12)
    slopes = np.diff(table, axis=0) / np.diff(grid)[:, None]
    assert low == pytest.approx(slopes.min(axis=0), abs=1e-9)
    assert high == pytest.approx(slopes.max(axis=0), abs=1e-9)
