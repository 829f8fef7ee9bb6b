"""The manipulability cost is what its docstring says: decreasing, capped, between zeta and 1."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import simpson

from planner.base.errors import OptionError
from planner.cost.scale import COSTS, ZETA, CostScale, manipulability_cost, mean_manipulability_cost, measure_scale

W = np.array([0.0, 0.01, 0.02, 0.04, 0.08, 0.2])
SCALE = CostScale(w_low=0.01, w_high=0.08, joint_length=1.0, tool_length=1.0, zeta=ZETA)


@pytest.mark.parametrize("name", COSTS)
def test_the_ends_are_one_and_zeta_and_between_it_falls(name) -> None:
    cost = manipulability_cost(W, SCALE, name)
    assert cost[[0, 1]] == pytest.approx(1.0)
    assert cost[[4, 5]] == pytest.approx(ZETA)
    assert (np.diff(cost[1:5]) < 0).all()


def test_each_cost_is_its_formula() -> None:
    shares = {"inverse": (1 / 0.02 - 1 / 0.08) / (1 / 0.01 - 1 / 0.08), "log": 2 / 3, "linear": 6 / 7}
    for name, share in shares.items():
        assert manipulability_cost(np.array([0.02]), SCALE, name)[0] == pytest.approx(ZETA + (1 - ZETA) * share)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", COSTS)
def test_the_mean_along_motions_is_simpsons_rule(name) -> None:
    w = np.random.default_rng(0).uniform(0.005, 0.1, (150, 9))
    expected = simpson(manipulability_cost(w, SCALE, name), dx=1 / 8, axis=1)
    np.testing.assert_allclose(mean_manipulability_cost(w, SCALE, name), expected, rtol=1e-13)
    assert mean_manipulability_cost(w[:0], SCALE, name).shape == (0,)


def test_a_roadmap_without_differences_or_edges_has_a_scale() -> None:
    scale = measure_scale(np.full(4, 0.1), np.zeros(0), np.zeros(0))
    assert (scale.joint_length, scale.tool_length) == (1.0, 1.0)
    assert manipulability_cost(np.full(4, 0.1), scale).tolist() == [ZETA] * 4
    assert manipulability_cost(np.zeros(2), measure_scale(np.zeros(2), np.ones(1), np.ones(1))).tolist() == [ZETA] * 2


def test_the_scale_is_measured_at_the_quantile_and_the_longest() -> None:
    scale = measure_scale(np.arange(1.0, 102.0), np.array([0.2, 0.7]), np.array([0.4, 0.1]))
    assert (scale.w_low, scale.w_high) == (pytest.approx(6.0), 101.0)
    assert (scale.joint_length, scale.tool_length) == (0.7, 0.4)


def test_an_unknown_cost_names_the_choices() -> None:
    with pytest.raises(OptionError, match="inverse"):
        manipulability_cost(W, SCALE, "square")  # type: ignore[arg-type]
