"""The splitting solver against a tight Runge-Kutta run, and its single steps."""

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import OptionError
from planner.gabf.problem import reduce
from planner.gabf.splitting import Stepper
from tests.gabf.test_solvers import NET, START

from .networks import from_arcs, scattered, solve


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
    stepper = Stepper(problem, gabf.Nominal().flow)
    here = stepper.standing(problem.pack(np.full(40, 50.0)))
    for _ in range(40):
        here, _ = stepper.step(here, 1e6, 1.0)
    assert problem.unpack(here.y) == pytest.approx(gabf.oracle(net), rel=1e-12)


def test_one_row_flows_exactly():
    net, step = from_arcs(2, [(1, 0, 1.0)]), 0.7
    problem = reduce(net)
    stepper = Stepper(problem, gabf.Nominal().flow)
    there, share = stepper.step(stepper.standing(np.array([9.0, 0.0])), step, 1.0)
    assert there.y[0] == pytest.approx(1.0 + 8.0 * np.exp(-step), rel=1e-12)
    assert share == 0.0


@pytest.mark.parametrize("bad", [{"tolerance": 0.0}, {"max_step": -1.0}, {"tolerance": np.inf}])
def test_numbers_that_make_no_step_are_refused(bad):
    with pytest.raises(OptionError):
        gabf.Splitting(**bad)
