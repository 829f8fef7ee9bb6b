import numpy as np
import pytest

from planner import gabf
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
