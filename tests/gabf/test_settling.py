"""When a run has settled."""

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import AssumptionError
from planner.gabf.problem import reduce
from planner.gabf.settling import error_bound, require_rooted
from planner.gabf.solvers import State
from tests.gabf.test_solve import NET

from .networks import from_arcs, scattered, solve


def test_settling_time_is_the_first_after_which_all_errors_stay_in_the_band():
    x_star = gabf.oracle(NET)
    for law in (gabf.SingularityFree(), gabf.Nominal()):
        for tolerance in (1e-2, 1e-9):
            result = solve(NET, law, save=gabf.EverySteps(1), settle_tolerance=tolerance)
            saved, finite = result.history, np.isfinite(x_star)
            error = np.abs(saved.x - x_star)[:, finite] / np.maximum(1, x_star[finite])
            inside = error.max(axis=1) <= tolerance
            last_outside = np.flatnonzero(~inside)[-1]
            assert saved.tau[last_outside] < result.settling_tau <= saved.tau[last_outside + 1]


def test_settling_time_converges_with_the_tolerance():
    tau = [solve(NET, solver=gabf.Splitting(tol)).settling_tau for tol in (0.05, 0.02, 0.005, 0.0005)]
    errors = np.abs(np.array(tau[:-1]) / tau[-1] - 1)
    assert errors[0] < 0.1
    assert errors[2] < 0.01
    assert errors[2] < errors[1] < errors[0]


def test_settled_from_the_start():
    result = solve(NET, x0=gabf.oracle(NET))
    assert (result.settling_tau, result.settling_time, result.steps) == (0.0, 0.0, 0)


@pytest.mark.parametrize("seed", range(3))
def test_the_bound_holds_wherever_it_is_finite(seed):
    """Far from the solution, near it, and above and below it."""
    net = scattered(60, seed=seed)
    problem, x_star = reduce(net), gabf.oracle(net)
    rng = np.random.default_rng(seed)
    result = gabf.solve(net)
    finite = 0
    for size in 10.0 ** rng.uniform(-9, 0, 40):
        y = problem.pack(np.where(np.isfinite(x_star), x_star, 0.0) + size * rng.normal(size=60))
        bound = error_bound(problem, result.premises, State(0.0, problem.standing(y), 1))
        error = np.abs(problem.unpack(y) - x_star)[problem.rows].max()
        assert error <= bound * (1 + 1e-12)
        finite += bool(np.isfinite(bound))
    assert finite > 10


def test_the_bound_is_met_where_a_kernel_doubles_every_error():
    """Each of eight nodes in a row a little above what it reads: e_i = 2 e_(i - 1) + r, so r (2^8 - 1) in the end."""
    net = from_arcs(9, [(i, i - 1, 1.0) for i in range(1, 9)], kernel=gabf.UserKernel(lambda i, a, b: 2 * a + b))
    problem, x_star, r = reduce(net), gabf.oracle(net), 1e-3
    y = x_star + r * (2.0 ** np.arange(9) - 1.0)
    result = gabf.solve(net)
    bound = error_bound(problem, result.premises, State(0.0, problem.standing(problem.pack(y)), 1))
    assert bound == pytest.approx(255 * r, rel=1e-6)


def test_a_residual_of_zero_without_a_root_is_no_solution():
    """Two nodes that hold each other at a value beside which the cost of an arc vanishes."""
    net = from_arcs(3, [(1, 0, 1.0), (1, 2, 1e-9), (2, 1, 1e-9)])
    problem = reduce(net)
    require_rooted(problem, problem.pack(gabf.oracle(net)))
    with pytest.raises(AssumptionError, match="stuck at -1e\\+10"):
        require_rooted(problem, problem.pack(np.array([0.0, -1e10, -1e10])))
