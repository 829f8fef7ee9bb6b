from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from planner.gabf.flows import LinearFlow, PowerFlow

PAPER = PowerFlow(1.0, 1.0, Fraction(3, 5), Fraction(9, 7))
OTHER = PowerFlow(0.3, 2.5, Fraction(1, 9), Fraction(5, 1))
FLOWS = [LinearFlow(), PAPER, OTHER, PowerFlow(2.0, 0.5, Fraction(9, 11), Fraction(15, 7))]


@pytest.mark.parametrize("flow", FLOWS)
def test_flow_follows_its_equation(flow):
    s = np.array([-3.0, -0.4, 0.2, 5.0])
    exact = solve_ivp(lambda _, s: -flow.rate(s), (0, 0.05), s, rtol=1e-11, atol=1e-13).y[:, -1]
    steps = s
    for _ in range(50):
        steps = flow.advance(steps, 0.001)
    assert np.allclose(steps, exact, rtol=2e-4, atol=1e-6)


@pytest.mark.parametrize("flow", FLOWS)
def test_flow_is_odd_rests_at_zero_and_never_overshoots(flow):
    s = np.array([0.0, 1e-12, 0.3, 1e9])
    for move in (flow.advance, flow.fastest):
        for dtau in (1e-6, 0.3, 50.0):
            moved = move(s, dtau)
            assert moved[0] == 0.0
            assert (moved >= 0).all()
            assert (moved <= s).all()
            assert np.array_equal(move(-s, dtau), -moved)


@pytest.mark.parametrize("flow", FLOWS)
def test_time_between_agrees_with_integration(flow):
    exact = solve_ivp(lambda s, _: [-1.0 / flow.rate(np.array([s]))[0]], (4.0, 0.01), [0.0], rtol=1e-10, atol=1e-13).y[
        0, -1
    ]
    assert flow.time_between(4.0, 0.01) == pytest.approx(exact, rel=1e-7)


FAR = [
    PowerFlow(b1, b2, p, q)
    for p in (Fraction(1, 99), Fraction(3, 5), Fraction(99, 101), Fraction(999_999, 1_000_001))
    for q in (Fraction(1_000_001, 999_999), Fraction(9, 7), Fraction(5), Fraction(999))
    for b1, b2 in ((1.0, 1.0), (0.02, 50.0), (50.0, 0.02))
]


@pytest.mark.parametrize("flow", [*FLOWS, *FAR], ids=str)
def test_slowest_and_fastest_enclose_the_flow_whatever_the_exponents(flow):
    """From s down to a half of it takes time_between; from there both bounds lie on their side of that half."""
    for s in (1e-12, 1e-3, 0.9, 1.1, 30.0):
        dtau = flow.time_between(s, 0.5 * s)
        if dtau < 1e-290:
            continue  # 30 falls to 15 within 1e-1475 where q = 999
        ends = [float(bound(np.array([s]), dtau)[0]) for bound in (flow.fastest, flow.slowest)]
        assert ends[0] <= 0.5 * s * (1 + 1e-9)
        assert ends[1] >= 0.5 * s * (1 - 1e-9)
        near = [
            float(bound(np.array([s]), 1e-3 * flow.time_between(s, 0.999 * s))[0])
            for bound in (flow.fastest, flow.slowest)
        ]
        assert near == pytest.approx([s, s], rel=1e-3)


@pytest.mark.parametrize("flow", [*FLOWS, *FAR], ids=str)
def test_steps_of_the_declared_length_err_by_a_per_cent_whatever_the_exponents(flow):
    for s in (1e-9, 1e-3, 0.9, 1.1):
        step = min(0.05 ** (1 / 3) * flow.longest_step(s), flow.time_between(s, 1e-3 * s))
        end = float(flow.advance(np.array([s]), step)[0])
        assert flow.time_between(s, end) == pytest.approx(step, rel=0.02)


def test_powers_that_overflow_do_not_make_a_state_vanish():
    flow = PowerFlow(1.0, 1.0, Fraction(3, 5), Fraction(99))
    for s in (1e4, 1e300):
        end = flow.advance(np.array([s]), 1e-3)[0]
        assert end == pytest.approx((98 * 1e-3) ** (-1 / 98), rel=1e-3)
