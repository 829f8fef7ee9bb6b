"""The learning rules against their formulae in plain Python; weights stay in (0, 1) whatever the parameters."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.base.errors import AssumptionError, OptionError
from planner.learning import ErrorDriven, Hebbian
from tests.random_shapes import QUICK

inside = st.floats(0.0, 1.0, exclude_min=True, exclude_max=True, allow_subnormal=False)
activity = st.floats(0.0, 1.0)
rate = st.floats(1e-6, 1e6)


def test_the_hebbian_rule_is_the_printed_one() -> None:
    rng = np.random.default_rng(0)
    wbar, a, b, d = rng.uniform(0.3, 0.6, 9), rng.random(9), rng.random(9), rng.uniform(0.1, 0.3, 9)
    changed = Hebbian(alpha=0.2, beta=2.0).updated(wbar, a, b, d)
    for k in range(9):
        assert changed[k] == pytest.approx(wbar[k] + 0.2 * a[k] * b[k] * (1.0 - 2.0 * d[k]), rel=1e-14)


def test_the_error_driven_rule_moves_by_its_gain_towards_its_fixed_point() -> None:
    rule = ErrorDriven(alpha=2.0, beta=0.5)
    wbar, d = np.array([0.5, 0.5, 0.95]), np.array([0.2, 0.2, 0.2])
    a, b = np.array([0.5, 1.0, 0.1]), np.array([0.5, 0.9, 0.2])
    # gains 0.5, 1 (1.8 capped) and 0.04; all weights go to 1 - 0.5 * 0.2 = 0.9
    assert rule.updated(wbar, a, b, d) == pytest.approx([0.7, 0.9, 0.95 - 0.04 * 0.05], rel=1e-14)
    assert rule.target(d) == pytest.approx([0.9, 0.9, 0.9])


@QUICK
@given(rate, rate, inside, activity, activity, st.floats(0.0, 1e6))
def test_hebbian_weights_stay_between_floor_and_ceiling(alpha, beta, wbar, a, b, d) -> None:
    rule = Hebbian(alpha=alpha, beta=beta)
    changed = rule.updated(*(np.array([value]) for value in (wbar, a, b, d)))
    assert 0.0 < rule.floor <= changed[0] <= rule.ceiling < 1.0


@QUICK
@given(rate, inside, activity, activity, inside)
def test_error_driven_weights_stay_in_the_open_interval(alpha, wbar, a, b, reach) -> None:
    d = 0.25
    beta = reach / d
    rule = ErrorDriven(alpha=alpha, beta=beta)
    if not 0.0 < 1.0 - beta * d < 1.0:
        with pytest.raises(AssumptionError):
            rule.target(np.array([d]))
        return
    changed, target = rule.updated(*(np.array([value]) for value in (wbar, a, b, d))), rule.target(np.array([d]))
    assert 0.0 < changed[0] < 1.0
    assert min(wbar, target[0]) <= changed[0] <= max(wbar, target[0])


def test_rounding_does_not_carry_a_weight_to_one() -> None:
    below_one = np.nextafter(1.0, 0.0)
    rule = ErrorDriven(alpha=1e9, beta=1.0)
    for wbar in (1e-300, 0.3, 0.5, 0.7, below_one):
        for d in (1.2e-16, 2.3e-16, 1e-15, 1.0 - 1e-16):
            changed = rule.updated(np.array([wbar]), np.ones(1), np.ones(1), np.array([d]))
            assert 0.0 < changed[0] < 1.0


def test_labels_tell_rules_and_parameters_apart() -> None:
    labels = {rule.label for rule in (Hebbian(), Hebbian(alpha=1.0), ErrorDriven(), ErrorDriven(beta=0.1))}
    assert len(labels) == 4


@pytest.mark.parametrize("kind", [Hebbian, ErrorDriven])
@pytest.mark.parametrize("bad", [0.0, -1.0, np.inf, np.nan])
def test_parameters_must_be_positive(kind, bad) -> None:
    with pytest.raises(OptionError, match="alpha"):
        kind(alpha=bad)
    with pytest.raises(OptionError, match="beta"):
        kind(beta=bad)


@pytest.mark.parametrize(("floor", "ceiling"), [(0.0, 0.9), (0.5, 0.5), (0.1, 1.0)])
def test_floor_and_ceiling_lie_in_the_open_interval(floor: float, ceiling: float) -> None:
    with pytest.raises(OptionError, match="floor"):
        Hebbian(floor=floor, ceiling=ceiling)


@pytest.mark.parametrize("d", [0.0, 1e-20, 10.0, 11.0, np.nan])
def test_a_distance_without_a_weight_is_refused(d: float) -> None:
    with pytest.raises(AssumptionError, match="beta"):
        ErrorDriven(beta=0.1).target(np.array([0.5, d]))
