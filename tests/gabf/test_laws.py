from typing import Any

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import OptionError

from .networks import AtTimes, scattered, solve

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
def test_the_control_input_is_the_derivative_of_the_state(law):
    t = np.array([0.05, 0.05 + 1e-5])
    saved = solve(NET, law, solver=gabf.Splitting(1e-3), save=AtTimes(t)).history
    slope = (saved.x[1] - saved.x[0]) / 1e-5
    finite = np.isfinite(slope)
    assert np.allclose(slope[finite], saved.u[0][finite], rtol=2e-3, atol=2e-3)


def test_eta_has_no_effect_under_the_singularity_free_law():
    save = gabf.EverySteps(1)
    one, two = (solve(NET, gabf.SingularityFree(eta=eta), x0=1.0, save=save) for eta in (0.01, 99.0))
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


def test_larger_h_and_gamma_settle_earlier():
    times = [solve(NET, gabf.SingularityFree(h=h)).settling_time for h in (1, 2, 4, 8)]
    assert times == sorted(times, reverse=True)
    assert solve(NET, gabf.SingularityFree(gamma=20)).settling_time < times[0]


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
