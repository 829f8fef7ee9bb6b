"""Facts that hold for every member of the family of solvers; adding one to the list tests it."""

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import OptionError

from .networks import AtTimes, chain, scattered, solve

NET = scattered(40, seed=2)
START = np.linspace(30.0, 60.0, 40)
UNTIL = 1.6

FIXED_STEP = {
    "splitting": lambda step: gabf.Splitting(tolerance=np.inf, max_step=step),
    "backward-euler": lambda step: gabf.BackwardEuler(step),
}
SOLVERS = [gabf.Splitting(), gabf.Splitting(1e-3), gabf.BackwardEuler(), gabf.RungeKutta45()]


def final_state(solver, law):
    result = solve(NET, law, x0=START, solver=solver, until_tau=UNTIL)
    assert result.end_tau == pytest.approx(UNTIL, abs=1e-12)
    return result.x[np.isfinite(result.x)]


@pytest.mark.parametrize("law", [gabf.Nominal(), gabf.SingularityFree()], ids=lambda law: law.name)
@pytest.mark.parametrize("name", FIXED_STEP)
def test_the_declared_order_is_the_measured_one(name, law):
    tight = final_state(gabf.RungeKutta45(rtol=1e-11, atol=1e-12), law)
    make = FIXED_STEP[name]
    steps = (UNTIL / 32, UNTIL / 64, UNTIL / 128)
    errors = [np.abs(final_state(make(step), law) - tight).max() for step in steps]
    measured = np.log2(errors[0] / errors[-1]) / 2
    assert measured == pytest.approx(make(1.0).order, abs=0.3)


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: s.name)
def test_every_solver_follows_the_same_trajectory(solver):
    t = np.array([0.0, 0.02, 0.05, 0.1])
    exact = solve(NET, x0=START, solver=gabf.RungeKutta45(1e-10, 1e-12), save=AtTimes(t), until_tau=1.5).history
    saved = solve(NET, x0=START, solver=solver, save=AtTimes(t), until_tau=1.5).history
    finite = np.isfinite(exact.x[0])
    assert np.array_equal(saved.t, t)
    assert np.allclose(saved.tau, exact.tau)
    assert np.abs(saved.x[:, finite] - exact.x[:, finite]).max() < 0.05 * np.abs(START - exact.x[-1])[finite].max()


@pytest.mark.parametrize("solver", [gabf.Splitting(0.01), gabf.BackwardEuler(0.002)], ids=lambda s: s.name)
@pytest.mark.parametrize("law", [gabf.Nominal(), gabf.SingularityFree()], ids=lambda law: law.name)
def test_solvers_agree_on_when_a_chain_settles(solver, law):
    """Node 1 alone is a scalar equation, so its settling time is known."""
    net = chain(2)
    result = solve(net, law, x0=3.0, solver=solver)
    assert result.settling_tau == pytest.approx(law.flow.time_between(2.0, 1e-9), rel=0.02)


def test_right_side_is_what_the_paper_writes():
    net, law = chain(3), gabf.SingularityFree()
    speed = gabf.right_side(net, law)(1.0, np.array([0.0, 3.0, 4.5]))
    gain = 10 + 4 / 3
    assert np.allclose(speed, [0.0, -gain * (2**0.6 + 2 ** (9 / 7)), -gain * (0.5**0.6 + 0.5 ** (9 / 7))])
    assert (gabf.right_side(net, law)(4.0, np.array([0.0, 3.0, 4.5])) == 0).all()


@pytest.mark.parametrize(
    "make",
    [
        lambda: gabf.Splitting(tolerance=0),
        lambda: gabf.Splitting(max_step=-1),
        lambda: gabf.Splitting(tolerance=np.inf),
        lambda: gabf.BackwardEuler(step=0),
        lambda: gabf.RungeKutta45(rtol=0),
    ],
)
def test_solver_parameters_are_validated(make):
    with pytest.raises(OptionError, match=r"solver|needs a finite"):
        make()
