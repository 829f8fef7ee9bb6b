import math

import numpy as np
import pytest

from planner.gabf.clock import PrescribedClock, UniformClock

CLOCK = PrescribedClock(T=4.0, h=1.0, gamma=10.0)


def test_tau_is_the_papers_formula():
    t = 1.5
    assert float(CLOCK.tau(t)) == pytest.approx(10 * t - 2 * (1 + 1) * math.log((4 - t) / 4))


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


def test_log10_remaining_agrees_with_t_where_both_resolve():
    remaining = 4.0 - float(CLOCK.time(30.0))
    assert CLOCK.log10_remaining(30.0) == pytest.approx(math.log10(remaining), rel=1e-10)


def test_time_is_known_however_large_gamma_T_is():
    steep = PrescribedClock(T=1e3, h=0.0, gamma=1e15)  # next to gamma T, 2 (1 + h) is lost in rounding
    assert float(steep.time(2e18)) == 1e3
    assert steep.log10_remaining(1e20) == pytest.approx((1e18 - 1e20) / 2 / math.log(10), rel=1e-12)


def test_a_share_too_small_for_a_double_is_no_error_whatever_numpy_is_to_raise():
    with np.errstate(all="raise"):
        assert float(CLOCK.time(1e4)) == 4.0
