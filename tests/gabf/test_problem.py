"""What the dynamics acts on: the rows that reach a source, against the network read arc by arc."""

import numpy as np
import pytest

from planner import gabf
from planner.gabf.problem import reduce_network

from .networks import from_arcs, scattered, solve

CUT_OFF = from_arcs(6, [(1, 0, 1.0), (2, 1, 0.5), (2, 0, 3.0), (3, 4, 1.0), (0, 1, 9.0), (5, 3, 1.0), (5, 2, 1.0)])


def test_arcs_of_sources_and_of_what_reaches_none_are_left_out():
    problem = reduce_network(CUT_OFF)
    assert problem.rows.tolist() == [1, 2, 5]
    ends = {(int(CUT_OFF.tails[a]), int(CUT_OFF.indices[a])) for a in problem.arc_ids}
    assert ends == {(1, 0), (2, 1), (2, 0), (5, 2)}
    assert problem.hops.tolist() == [1, 1, 2]


@pytest.mark.parametrize("seed", range(5))
def test_the_overestimate_is_strict_and_infinite_only_where_unreachable(seed):
    net = scattered(50, seed=seed, degree=2)
    x, x_star = gabf.overestimate(net), gabf.oracle(net)
    rows = np.setdiff1d(np.flatnonzero(np.isfinite(x_star)), net.sources)
    assert (x[rows] > x_star[rows]).all()
    assert np.array_equal(np.isfinite(x), np.isfinite(x_star))


def test_the_state_stays_in_the_interval_that_was_promised():
    net = scattered(80, seed=3)
    x0 = np.random.default_rng(0).uniform(-20, 40, 80)
    result = solve(net, x0=x0)
    assert result.premises.lower <= result.lowest
    assert result.highest <= result.premises.upper


def test_unreachable_nodes_are_infinite_and_left_out():
    net = from_arcs(5, [(1, 0, 1.0), (2, 3, 1.0), (3, 2, 1.0), (1, 2, 1.0), (0, 4, 1.0)])
    result = solve(net, x0=np.array([0.0, 5.0, np.nan, np.inf, 0.0]))
    assert result.x.tolist() == [0.0, 1.0, np.inf, np.inf, np.inf]
    assert gabf.structure(net).unreachable.tolist() == [2, 3, 4]
