"""Upper and lower solutions: runs with small steps stay between them, however a step of theirs was found."""

import numpy as np
import pytest

from planner import gabf
from planner.gabf import sub_super_solutions as sides
from planner.gabf.problem import reduce
from planner.gabf.sub_super_solutions import Side, limit

from .networks import AtTimes, scattered, solve
from .random_runs import draw


def both_sides(net, result):
    """The upper and the lower one of a run."""
    problem, y_star = reduce(net), gabf.oracle(net)
    y0, y_star = problem.pack(result.x0), problem.pack(y_star)
    flow, bounds = result.law.flow, result.premises
    return [Side(problem, flow, y0, bounds, upper, limit(problem, y0, y_star, upper)) for upper in (True, False)]


@pytest.mark.parametrize("seed", range(300, 306))
def test_states_stay_between_the_sides(seed):
    law, net, x0 = draw(seed, 12)
    result, problem = solve(net, law, x0), reduce(net)
    times = np.linspace(0.0, 1.2, 13) * float(law.clock.time(result.settling_tau))
    times = np.unique(times[np.isfinite(law.clock.tau(times))])
    saved = solve(net, law, x0, gabf.Splitting(1e-3), AtTimes(times)).history
    spread = np.ptp(x0) + np.ptp(result.x) + 1.0
    pair = both_sides(net, result)
    for before, tau, x in zip(saved.tau, saved.tau[1:], saved.x[1:], strict=False):
        for side in pair:
            for _ in range(64):
                side.step((tau - before) / 64)
            assert (side.sign * (side.y - problem.pack(x)) >= -1e-3 * spread).all()


@pytest.mark.parametrize("start", [40.0, 0.0, "mixed"])
def test_a_step_is_the_same_whether_all_rows_are_looked_at_again_or_those_that_read_a_change(monkeypatch, start):
    net = scattered(300, seed=5)
    x0 = np.random.default_rng(5).uniform(0.0, 8.0, 300) if start == "mixed" else start
    result = solve(net, x0=x0)
    looked_at = []
    monkeypatch.setattr(Side, "_reading", lambda *a, real=Side._reading: looked_at.append(1) or real(*a))
    ends = []
    monkeypatch.setattr(sides, "_FEW_OF", 0)
    for few in (-1.0, 1.0):
        monkeypatch.setattr(sides, "_FEW", few)
        pair = both_sides(net, result)
        for side in pair:
            for _ in range(40):
                side.step(result.settling_tau / 40)
        ends.append([side.y for side in pair])
        assert bool(looked_at) == (few > 0)
    np.testing.assert_array_equal(ends[0], ends[1])


def test_a_step_that_no_guess_proves_holds_parents_as_far_out_as_the_fastest_state_moves(monkeypatch):
    net = scattered(80, seed=5)
    result = solve(net, x0=40.0)
    tau = result.settling_tau / 10
    guessed = both_sides(net, result)
    monkeypatch.setattr(sides, "_SWEEPS", 0)
    for side, other in zip(both_sides(net, result), guessed, strict=True):
        for _ in range(6):
            side.step(tau)
            other.step(tau)
        truth = solve(net, x0=40.0, solver=gabf.Splitting(1e-3), save=AtTimes(result.law.clock.time([side.tau])))
        for found in (side, other):
            assert (found.sign * (found.y - reduce(net).pack(truth.history.x[0])) >= -1e-3).all()


@pytest.mark.parametrize("upper", [True, False])
def test_no_run_goes_beyond_the_limit_which_is_the_optimum_for_starts_on_the_other_side_of_it(upper):
    net = scattered(60, seed=4)
    problem, x_star = reduce(net), gabf.oracle(net)
    y_star = problem.pack(x_star)
    mixed = x_star + np.random.default_rng(4).uniform(-1.0, 1.0, 60)
    beyond = limit(problem, problem.pack(mixed), y_star, upper)
    run = solve(net, x0=mixed, save=gabf.EverySteps()).history.x
    sign = 1.0 if upper else -1.0
    assert (sign * (beyond - run[:, problem.nodes]) >= -1e-12).all()
    inside = problem.pack(x_star - 0.5 * sign)
    np.testing.assert_array_equal(limit(problem, inside, y_star, upper), y_star)
