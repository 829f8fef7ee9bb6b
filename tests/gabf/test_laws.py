"""The four laws and their clocks."""

import math

import numpy as np
import pytest

from planner import gabf
from planner.gabf import PrescribedClock, UniformClock

from . import judge
from .networks import scattered, solve

NET = scattered(60)
LAWS = [gabf.Nominal(), gabf.PrescribedTime(), gabf.FixedTime(), gabf.SingularityFree()]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_the_control_input_is_the_papers_right_side(law):
    """dx_i/dt = -(d tau/dt) phi(x_i - min_j f_i), written out, at every saved state."""
    saved, t_step = solve(NET, law, save_every=1).history, 1e-7
    for tau, t, x, u in list(zip(saved.tau, saved.t, saved.x, saved.u, strict=True))[:5]:
        pace = (law.clock.tau(t + t_step) - tau) / t_step
        for i in np.setdiff1d(np.flatnonzero(np.isfinite(x)), NET.sources)[::7]:
            arcs = slice(NET.indptr[i], NET.indptr[i + 1])
            xhat = x[i] - NET.arcs(x[NET.indices])[arcs].min()
            linear = isinstance(law, gabf.Nominal | gabf.PrescribedTime)
            size = abs(xhat) if linear else abs(xhat) ** 0.6 + abs(xhat) ** (9 / 7)
            assert u[i] == pytest.approx(-np.sign(xhat) * pace * size, rel=1e-4, abs=1e-6)


def test_eta_has_no_effect_under_the_singularity_free_law():
    one, two = (solve(NET, gabf.SingularityFree(eta=eta), x0=1.0, save_every=1) for eta in (0.01, 99.0))
    assert np.array_equal(one.history.x, two.history.x)
    assert np.array_equal(one.history.u, two.history.u)
    assert one.settling_tau == two.settling_tau


def test_eta_scales_time_under_the_others():
    slow, fast = (solve(NET, gabf.FixedTime(eta=eta)) for eta in (1.0, 4.0))
    assert slow.settling_time == pytest.approx(4 * fast.settling_time, rel=1e-12)


CLOCK = PrescribedClock(T=4.0, h=1.0, gamma=10.0)


@pytest.mark.parametrize("clock", [CLOCK, PrescribedClock(0.1, 8.0, 0.01), UniformClock(3.0)])
def test_time_inverts_tau(clock):
    t = np.linspace(0.0, 0.0999, 200)
    assert np.allclose(clock.time(clock.tau(t)), t, rtol=1e-12, atol=1e-15)


def test_gain_is_the_derivative_of_tau():
    t, step = np.linspace(0.1, 3.8, 30), 1e-6
    slope = (CLOCK.tau(t + step) - CLOCK.tau(t - step)) / (2 * step)
    assert np.allclose(np.exp(CLOCK.log_gain(CLOCK.tau(t))), slope, rtol=1e-7)
    assert np.allclose(np.exp(CLOCK.log_gain(CLOCK.tau(t))), 10 + 2 * 2 / (4 - t), rtol=1e-12)


def test_the_law_is_inert_from_the_prescribed_time_on():
    assert CLOCK.tau(4.0) == np.inf
    assert CLOCK.tau(9.0) == np.inf
    assert CLOCK.log_gain(np.inf) == -np.inf
    assert CLOCK.time(np.inf) == 4.0


def test_no_double_below_T_is_left_beyond_188_but_the_logarithm_is():
    assert CLOCK.time(186.0) < 4.0
    assert CLOCK.time(190.0) == 4.0
    assert CLOCK.log10_remaining(1e5) == pytest.approx((40 - 1e5) / 4 / math.log(10) + math.log10(4), rel=1e-12)
    assert UniformClock(2.0).log10_remaining(5.0) is None


def test_time_is_known_however_large_gamma_T_is():
    steep = PrescribedClock(T=1e3, h=1e-15, gamma=1e15)  # next to gamma T, 2 (1 + h) is lost in rounding
    assert float(steep.time(2e18)) == 1e3
    assert steep.log10_remaining(1e20) == pytest.approx((1e18 - 1e20) / 2 / math.log(10), rel=1e-12)


def power(p):
    return lambda s: np.sign(s) * np.abs(s) ** p


RATES = {
    "tanh": np.tanh,
    "saturated": lambda s: np.clip(s, -2.0, 2.0),
    "root": power(0.5),
    "cube": power(3.0),
    "two powers": lambda s: power(0.6)(s) + power(9 / 7)(s),
    "one-sided": lambda s: np.where(s > 0, s, 4.0 * s),
    "slow far away": lambda s: s / (1.0 + s * s),
    "steep": lambda s: np.sinh(np.clip(s, -700, 700)),
    "sign": np.sign,
}


def test_nothing_is_proven_of_when_an_own_law_settles():
    law = gabf.UserLaw(np.tanh)
    found = gabf.certify(NET, law, solve(NET, law, x0=0.0))
    assert {c.equation for c in found} == {"lemma (globalbound)", "lemma (globalexistence)"}
    assert all(c.holds and not c.proven for c in found)


@pytest.mark.parametrize("name", ["tanh", "saturated", "root", "two powers", "one-sided", "slow far away"])
def test_an_own_law_passes_where_an_independent_integrator_does(name):
    net, law, start = scattered(30, seed=2), gabf.UserLaw(RATES[name]), np.linspace(5.0, 9.0, 30)
    for tau, exact in zip([0.4, 2.0], judge.states(net, law, start, [0.4, 2.0]), strict=True):
        for tolerance, share in ((0.05, 0.02), (1e-3, 1e-3)):
            x = solve(net, law, start, gabf.Splitting(tolerance), until_tau=tau).x
            finite = np.isfinite(exact)
            assert np.abs(x - exact)[finite].max() < share * np.abs(start - exact)[finite].max()
