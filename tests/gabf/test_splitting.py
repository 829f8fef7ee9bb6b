"""The splitting solver against Radau's method, its single steps, and the rows that it stops looking at."""

import numpy as np
import pytest

from planner import gabf
from planner.gabf.problem import reduce_network
from planner.gabf.splitting import Parents, make_parents, run

from . import judge
from .networks import chain, scattered, solve
from .random_runs import draw_extreme

NET = scattered(40, seed=2)
START = np.linspace(30.0, 60.0, 40)
UNTIL = 1.6
LAWS = [gabf.Nominal(), gabf.SingularityFree()]
KERNELS = [gabf.TradeOff(0.5), gabf.Multiplicative(K=20.0), gabf.UserKernel(lambda i, a, b: a + b + 0.1 * (i % 3))]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_fixed_steps_are_of_second_order(law):
    exact = judge.states(NET, law, START, [UNTIL], rtol=1e-11)[0]
    errors = []
    for steps in (32, 64, 128):
        result = solve(NET, law, START, gabf.Splitting(np.inf, UNTIL / steps), until_tau=UNTIL)
        assert result.end_tau == UNTIL
        errors.append(np.abs(result.x - exact)[np.isfinite(exact)].max())
    assert np.log2(errors[0] / errors[-1]) / 2 == pytest.approx(2, abs=0.3)


@pytest.mark.parametrize("tolerance", [0.05, 1e-3])
def test_states_are_those_of_an_independent_integrator(tolerance):
    law = gabf.SingularityFree()
    for tau, exact in zip([0.3, 0.9, 1.5], judge.states(NET, law, START, [0.3, 0.9, 1.5]), strict=True):
        x = solve(NET, law, START, gabf.Splitting(tolerance), until_tau=tau).x
        finite = np.isfinite(exact)
        assert np.abs(x - exact)[finite].max() < 0.05 * np.abs(START - exact)[finite].max()


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_one_node_settles_when_its_scalar_equation_says(law):
    result = solve(chain(2), law, 3.0, gabf.Splitting(0.01))
    assert result.estimated_tau == pytest.approx(law.flow.time_between(2.0, 1e-9), rel=0.02)


def test_large_steps_are_sweeps_of_bellman_and_ford():
    """Forty of them take forty nodes to the fixed point, as value iteration does."""
    problem = reduce_network(NET)
    parents = make_parents(problem, gabf.Nominal().flow)
    here = parents.state(problem.pack(np.full(40, 50.0)))
    for _ in range(40):
        here, _ = parents.step(here, 1e6, 1.0)
    assert problem.unpack(here.y) == pytest.approx(gabf.oracle(NET), rel=1e-12)


def tried(net, law, x0):
    """The steps that a run tries until it is at rest; no end within 20,000 is a failure."""
    problem, count = reduce_network(net), 0
    y0 = problem.pack(np.broadcast_to(np.asarray(x0, dtype=float), net.n_nodes))
    for steps, state in enumerate(run(problem, law.flow, y0, gabf.Splitting())):
        count = steps + state.rejected
        assert count < 20_000
        if state.residual == 0.0:
            break
    return count


def test_laws_settle_at_every_exponent_and_magnitude():
    """Costs and starts from 1e-30 to 1e30, coefficients 1e12 apart, every pair of exponents from 1/99 to 99."""
    most = 0
    for seed in range(400):
        law, net, x0 = draw_extreme(seed)
        result = solve(net, law, x0)
        assert result.outcome is gabf.Ending.SETTLED, seed
        assert gabf.oracle(net) == pytest.approx(result.x, rel=1e-9, abs=0), seed
        most = max(most, tried(net, law, x0))
    assert most < 10_000


@pytest.mark.parametrize("kernel", KERNELS[:2], ids=lambda k: type(k).__name__)
def test_a_compiled_step_is_that_of_any_kernel(kernel):
    problem = reduce_network(scattered(300, seed=1, kernel=kernel))
    y = problem.pack(np.random.default_rng(0).uniform(0, 0.9, 300))
    flow = gabf.SingularityFree().flow
    compiled, plain = make_parents(problem, flow), Parents(problem, flow)
    pairs = list(zip(compiled.state(y), plain.state(y), strict=True))
    at = plain.state(y)
    ours, theirs = (parents.step(at, 0.1, 1.0) for parents in (compiled, plain))
    for one, other in [*pairs, *zip(ours[0], theirs[0], strict=True), (ours[1], theirs[1])]:
        np.testing.assert_allclose(one, other, rtol=1e-14)
