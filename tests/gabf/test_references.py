"""The textbook solvers."""

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import OptionError
from planner.gabf.problem import reduce
from planner.gabf.references import implicit_step
from tests.gabf.test_solvers import NET, START

from .networks import AtTimes, chain, solve


def test_rk45_has_order_five_where_the_flow_is_smooth():
    net, law = chain(3), gabf.Nominal()
    errors = []
    for step in (0.4, 0.2):
        solver = gabf.RungeKutta45(rtol=1.0, atol=1e3, max_step=step)
        x = solve(net, law, x0=9.0, solver=solver, until_tau=4.0, save=AtTimes([4.0])).history.x[0]
        errors.append(abs(x[2] - (2 + np.exp(-4.0) * (7 + 8 * 4.0))))
    assert np.log2(errors[0] / errors[1]) > 4.5


def test_rk45_chatters_and_says_that_nothing_is_proved():
    result = solve(NET, solver=gabf.RungeKutta45(), until_tau=40.0)
    assert result.outcome is gabf.Ending.BUDGET_SPENT
    assert result.settling_tau is None
    assert gabf.max_error(result, gabf.oracle(NET)) <= result.error_bound


def test_rk45_settles_on_a_loose_tolerance():
    result = solve(NET, gabf.Nominal(), solver=gabf.RungeKutta45(1e-9, 1e-12), settle_tolerance=1e-3)
    assert result.outcome is gabf.Ending.SETTLED
    assert gabf.max_error(result, gabf.oracle(NET)) <= 1e-3


def test_the_right_side_is_the_papers_equation():
    """dx_i/dt = -dtau/dt phi(x_i - min_j f_i), written out; sources stand still."""
    law = gabf.PrescribedTime(T=4.0, h=1.0, gamma=1.0)
    x, t, step = START.copy(), 1.3, 1e-6
    x[NET.sources] = NET.source_values
    found = gabf.right_side(NET, law)(t, x)
    pace = (law.clock.tau(t + step) - law.clock.tau(t - step)) / (2 * step)
    finite = np.isfinite(gabf.oracle(NET))
    for i in np.flatnonzero(finite):
        if i in NET.sources:
            assert found[i] == 0.0
            continue
        arcs = np.flatnonzero(NET.tails == i)
        best = NET.arcs(x[NET.indices])[arcs[finite[NET.indices[arcs]]]].min()
        assert found[i] == pytest.approx(-pace * law.flow.rate(np.array([x[i] - best]))[0], rel=1e-6)
    assert (found[~finite] == 0).all()


def test_an_implicit_step_solves_its_equation():
    problem, flow = reduce(NET), gabf.SingularityFree().flow
    y = problem.pack(START)
    new, sweeps = implicit_step(problem, flow, y, 0.3)
    rows = problem.n_rows
    rest = new[:rows] - y[:rows] + 0.3 * flow.rate(new[:rows] - problem.parent_values(new))
    assert np.abs(rest).max() < 1e-10
    assert sweeps > 1


@pytest.mark.parametrize(
    "make", [lambda: gabf.BackwardEuler(0.0), lambda: gabf.RungeKutta45(rtol=-1.0), lambda: gabf.RungeKutta45(atol=0.0)]
)
def test_steps_and_tolerances_are_positive(make):
    with pytest.raises(OptionError):
        make()
