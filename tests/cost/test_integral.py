"""States that a motion's cost is integrated over."""

from __future__ import annotations

import re

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.resolutions import W_IN_COST, W_STATES_PER_EDGE
from planner.cost.integral import costs_along, w_along
from planner.cost.scale import COSTS, manipulability_cost
from planner.kinematics.manipulability import manipulability, manipulability_along
from tests.documents import ROOT
from tests.worlds import load, random_q, small_plan


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


def test_every_motion_is_looked_at_once_from_end_to_end() -> None:
    robot = load("iiwa14")
    start = random_q(robot, 40, seed=1)
    delta = np.random.default_rng(2).uniform(-1, 1, start.shape) * np.linspace(0, 3, 40)[:, None]
    seen = np.zeros(40, dtype=int)
    length = np.linalg.norm(delta, axis=1)
    for rows, w in w_along(robot, start, delta, length):
        seen[rows] += 1
        np.testing.assert_allclose(w[:, 0], manipulability(robot, start[rows]), rtol=1e-9)
        np.testing.assert_allclose(w[:, -1], manipulability(robot, (start + delta)[rows]), rtol=1e-9)
    assert (seen == 1).all()


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
