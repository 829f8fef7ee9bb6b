"""The four laws and their clocks."""

import math
from typing import Any

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import OptionError
from planner.gabf.laws import PrescribedClock, UniformClock

from .networks import scattered, solve

NET = scattered(60)
TRIPLE: Any = (9, 7, 5)
LAWS = [gabf.Nominal(), gabf.PrescribedTime(), gabf.FixedTime(), gabf.SingularityFree()]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_every_law_settles_on_the_optimum_from_its_default_start(law):
    result = solve(NET, law=law)
    assert result.outcome is gabf.Ending.SETTLED
    assert np.array_equal(result.x, gabf.oracle(NET))
    assert solve(NET, law=law).settling_tau == result.settling_tau


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


def test_prescribed_laws_keep_their_deadline_for_any_T():
    for T in (1e-3, 1.0, 1e6):
        result = solve(NET, gabf.SingularityFree(T=T))
        assert result.settling_time < T
        assert result.log10_remaining < np.log10(T)
        assert solve(NET, gabf.PrescribedTime(T=T)).settling_time <= T


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: gabf.Nominal(eta=0), "eta must be a positive"),
        (lambda: gabf.PrescribedTime(T=-1), "T must be a positive"),
        (lambda: gabf.PrescribedTime(h=0), "h must be a positive"),
        (lambda: gabf.SingularityFree(gamma=np.inf), "gamma must be a positive finite"),
        (lambda: gabf.SingularityFree(beta1=np.nan), "beta1 must be a positive"),
        (lambda: gabf.SingularityFree(p=(5, 3)), "p1 < p2"),
        (lambda: gabf.SingularityFree(m=(7, 9)), "m1 > m2"),
        (lambda: gabf.FixedTime(p=(2, 5)), "odd integers"),
        (lambda: gabf.FixedTime(m=(9, 0)), "odd integers"),
        (lambda: gabf.FixedTime(m=TRIPLE), "two positive odd integers"),
    ],
)
def test_parameters_are_validated(make, message):
    with pytest.raises(OptionError, match=message):
        make()


@pytest.mark.parametrize("law", [gabf.FixedTime, gabf.SingularityFree])
def test_coefficients_whose_times_no_double_holds_are_refused(law):
    assert law(beta1=1e200, beta2=1e-200).flow.total_time < 1e300
    for beta in (1e-260, 1e260):
        with pytest.raises(OptionError, match="bring both closer to 1"):
            law(beta1=beta, beta2=beta)


CLOCK = PrescribedClock(T=4.0, h=1.0, gamma=10.0)


@pytest.mark.parametrize("clock", [CLOCK, PrescribedClock(0.1, 8.0, 0.01), UniformClock(3.0)])
def test_time_inverts_tau(clock):
    t = np.linspace(0.0, 0.0999, 200)
    assert np.allclose(clock.time(clock.tau(t)), t, rtol=1e-12, atol=1e-15)


def test_tau_of_the_first_moments_is_not_lost_in_rounding():
    short = PrescribedClock(T=1e-3, h=8.0, gamma=1.0)
    for t in (1e-30, 1e-19, 1e-15, 1e-10):
        assert float(short.tau(t)) == pytest.approx(t + 18.0 * (t / 1e-3 + 0.5 * (t / 1e-3) ** 2), rel=1e-12, abs=0.0)
        assert float(short.time(short.tau(t))) == pytest.approx(t, rel=1e-12, abs=0.0)


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
    steep = PrescribedClock(T=1e3, h=0.0, gamma=1e15)  # next to gamma T, 2 (1 + h) is lost in rounding
    assert float(steep.time(2e18)) == 1e3
    assert steep.log10_remaining(1e20) == pytest.approx((1e18 - 1e20) / 2 / math.log(10), rel=1e-12)
