"""The splitting solver against a tight Runge-Kutta run, and its single steps."""

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import OptionError
from planner.gabf.parents import parents_of
from planner.gabf.problem import reduce
from planner.gabf.splitting import Field
from tests.gabf.test_solvers import NET, START

from .networks import chain, from_arcs, scattered, solve
from .random_runs import draw_extreme


@pytest.mark.parametrize("start", [None, 0.0, START], ids=["above", "zeros", "ramp"])
@pytest.mark.parametrize("law", [gabf.Nominal(), gabf.SingularityFree()], ids=lambda law: law.name)
def test_splitting_settles_when_a_tight_rk45_does(law, start):
    times = [
        solve(NET, law, start, solver, settle_tolerance=1e-3).settling_tau
        for solver in (gabf.Splitting(0.002), gabf.RungeKutta45(1e-8, 1e-10))
    ]
    assert times[0] == pytest.approx(times[1], rel=0.02)


def test_large_steps_are_sweeps_of_bellman_and_ford():
    """Forty of them take forty nodes to the fixed point, as value iteration does."""
    net = scattered(40, seed=2)
    problem = reduce(net)
    parents, flow = parents_of(problem), gabf.Nominal().flow
    here = parents.standing(problem.pack(np.full(40, 50.0)))
    for _ in range(40):
        here, _ = parents.step(flow, here, 1e6, 1.0)
    assert problem.unpack(here.y) == pytest.approx(gabf.oracle(net), rel=1e-12)


def test_one_row_flows_exactly():
    net, step = from_arcs(2, [(1, 0, 1.0)]), 0.7
    problem = reduce(net)
    parents = parents_of(problem)
    there, share = parents.step(gabf.Nominal().flow, parents.standing(np.array([9.0, 0.0])), step, 1.0)
    assert there.y[0] == pytest.approx(1.0 + 8.0 * np.exp(-step), rel=1e-12)
    assert share == 0.0


@pytest.fixture
def tried(monkeypatch):
    """How many steps were tried since it was cleared; a run that tries 20,000 fails, where it might have no end."""
    steps, attempt = [], Field.attempt

    def counted(field, dtau, size):
        steps.append(dtau)
        assert len(steps) < 20_000
        return attempt(field, dtau, size)

    monkeypatch.setattr(Field, "attempt", counted)
    return steps


NEAR_ONE = {"p": (99, 101), "m": (101, 99)}
FAR_FROM_ONE = {"p": (1, 99), "m": (99, 1)}
NEAR_AND_FAR = {"p": (1, 99), "m": (101, 99)}


@pytest.mark.parametrize(
    ("powers", "start", "cost"),
    [(NEAR_ONE, 1e30, 1.0), (NEAR_AND_FAR, 1e30, 1.0), (FAR_FROM_ONE, 1e4, 1.0), (NEAR_AND_FAR, 0.0, 3e29)],
    ids=["costs lost in rounding", "and fast near rest", "speed beyond doubles", "rounding beyond speed"],
)
def test_runs_that_had_no_end_settle_on_the_optimum(powers, start, cost, tried):
    result = solve(chain(6, cost), gabf.FixedTime(eta=1.0, **powers), start)
    assert result.outcome is gabf.Ending.SETTLED
    assert np.array_equal(result.x, gabf.oracle(chain(6, cost)))
    assert len(tried) < 5_000


def test_laws_settle_at_every_exponent_and_magnitude(tried):
    """Costs and starts from 1e-30 to 1e30, coefficients 1e12 apart, every pair of exponents from 1/99 to 99."""
    most = 0
    for seed in range(400):
        law, net, x0 = draw_extreme(seed)
        tried.clear()
        result = solve(net, law, x0)
        assert result.outcome is gabf.Ending.SETTLED, seed
        assert gabf.oracle(net) == pytest.approx(result.x, rel=1e-9, abs=0), seed
        most = max(most, len(tried))
    assert most < 10_000


def test_a_step_that_is_never_good_enough_is_rejected_a_counted_number_of_times(monkeypatch):
    monkeypatch.setattr(Field, "attempt", lambda field, dtau, size: np.nan)
    result = solve(chain(6), gabf.FixedTime(), 9.0, max_steps=200)
    assert result.outcome is gabf.Ending.BUDGET_SPENT
    assert result.evaluations < 1000


@pytest.mark.parametrize("bad", [{"tolerance": 0.0}, {"max_step": -1.0}, {"tolerance": np.inf}])
def test_numbers_that_make_no_step_are_refused(bad):
    with pytest.raises(OptionError):
        gabf.Splitting(**bad)
