"""The manipulability cost is what its docstring says: decreasing, capped, between zeta and 1."""

import re

import numpy as np
import pytest
from scipy.integrate import simpson

from planner.base.arrays import Floats, Ints
from planner.base.errors import OptionError
from planner.base.resolutions import W_IN_COST, W_STATES_PER_EDGE
from planner.cost.scale import (
    COSTS,
    ZETA,
    CostScale,
    costs_along,
    manipulability_cost,
    mean_manipulability_cost,
    measure_scale,
    w_along,
)
from planner.kinematics.manipulability import manipulability, manipulability_along
from tests.documents import ROOT
from tests.worlds import load, random_q, small_plan

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
        assert manipulability_cost(np.array([0.02]), SCALE, name)[0] == pytest.approx(ZETA + (1 - ZETA) * share)


@pytest.mark.parametrize("name", COSTS)
def test_the_mean_along_motions_is_simpsons_rule(name) -> None:
    w = np.random.default_rng(0).uniform(0.005, 0.1, (150, 9))
    expected = simpson(manipulability_cost(w, SCALE, name), dx=1 / 8, axis=1)
    np.testing.assert_allclose(mean_manipulability_cost(w, SCALE, name), expected, rtol=1e-13)
    assert mean_manipulability_cost(w[:0], SCALE, name).shape == (0,)


def test_the_scale_is_measured_at_the_quantile_and_the_longest() -> None:
    scale = measure_scale(np.arange(1.0, 102.0), np.array([0.2, 0.7]), np.array([0.4, 0.1]))
    assert (scale.w_low, scale.w_high) == (pytest.approx(6.0), 101.0)
    assert (scale.joint_length, scale.tool_length) == (0.7, 0.4)


def test_an_unknown_cost_names_the_choices() -> None:
    with pytest.raises(OptionError, match="inverse"):
        manipulability_cost(W, SCALE, "square")


def states_on(length: Floats) -> Ints:
    """(k,) how many states there are on motions of a ``length`` (k,)."""
    still, states = np.zeros((len(length), 2)), np.zeros(len(length), dtype=np.int64)
    for rows, w in w_along(load("planar_2r"), still, still, length):
        states[rows] = w.shape[1]
    return states


def test_states_lie_close_enough() -> None:
    length = np.concatenate([[0.0, 0.9, np.nextafter(0.9, 1.0)], np.random.default_rng(0).uniform(0, 100, 500)])
    states = states_on(length)
    assert states[:3].tolist() == [9, 9, 17]
    assert (length / (states - 1) <= W_IN_COST * (1 + 1e-12)).all()
    assert ((states - 1) % (W_STATES_PER_EDGE - 1) == 0).all()
    assert states_on(np.array([1e6])) == states_on(np.array([114.0]))


def test_means_of_all_costs_against_a_fine_sum() -> None:
    made = small_plan()
    robot, scale = made.robot, made.roadmap.scale
    start, delta = random_q(robot, 20, seed=3), 0.4 * np.random.default_rng(4).normal(size=(20, robot.dof))
    few, found = costs_along(robot, start, delta, scale)
    shares = np.linspace(0.0, 1.0, W_STATES_PER_EDGE)
    np.testing.assert_array_equal(few, manipulability_along(robot, start, delta, shares))
    for k, name in enumerate(COSTS):
        for q, way, mean in zip(start, delta, found[:, k], strict=True):
            w = manipulability(robot, q + (np.arange(4000)[:, None] + 0.5) / 4000 * way)
            assert abs(mean / manipulability_cost(w, scale, name).mean() - 1) < 0.06
    assert costs_along(robot, start[:0], delta[:0], scale)[1].shape == (0, len(COSTS))


def test_the_page_says_how_far_the_means_are_off() -> None:
    page = (ROOT / "docs/explanation/laws_and_clocks.md").read_text()
    told = re.search(
        r"720 .* (\S+) % off in the mean and (\S+) % at\s+most with `log`, and (\S+) % and (\S+) % with", page
    )
    assert told
    made = small_plan()
    robot, scale = made.robot, made.roadmap.scale
    off = np.empty((4, 180, len(COSTS)))
    for seed in range(4):
        rng, start = np.random.default_rng(seed), random_q(robot, 180, seed=seed)
        way = rng.normal(size=start.shape)
        way *= (rng.uniform(0.5, 3.0, 180) / np.linalg.norm(way, axis=1))[:, None]
        found = costs_along(robot, start, way, scale)[1]
        w = manipulability_along(robot, start, way, (np.arange(2000) + 0.5) / 2000)
        for k, name in enumerate(COSTS):
            fine = manipulability_cost(w.ravel(), scale, name).reshape(w.shape).mean(axis=1)
            off[seed, :, k] = np.abs(found[:, k] / fine - 1)
    log, inverse = 100 * off[..., COSTS.index("log")], 100 * off[..., COSTS.index("inverse")]
    seen = [log.mean(), log.max(), inverse.mean(), inverse.max()]
    assert np.allclose(seen, [float(number) for number in told.groups()], rtol=0.05)
