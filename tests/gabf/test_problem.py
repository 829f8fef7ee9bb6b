"""What the dynamics acts on: the rows that reach a source, against the network read arc by arc."""

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import AssumptionError
from planner.gabf.problem import field, reduce

from .networks import from_arcs, scattered

CUT_OFF = from_arcs(6, [(1, 0, 1.0), (2, 1, 0.5), (2, 0, 3.0), (3, 4, 1.0), (0, 1, 9.0), (5, 3, 1.0), (5, 2, 1.0)])


def test_arcs_of_sources_and_of_what_reaches_none_are_left_out():
    problem = reduce(CUT_OFF)
    assert problem.rows.tolist() == [1, 2, 5]
    ends = {(int(CUT_OFF.tails[a]), int(CUT_OFF.indices[a])) for a in problem.arc_ids}
    assert ends == {(1, 0), (2, 1), (2, 0), (5, 2)}
    assert problem.hops.tolist() == [1, 1, 2]


@pytest.mark.parametrize("kernel", [gabf.TradeOff(0.5), gabf.Multiplicative(K=20.0)], ids=lambda k: type(k).__name__)
def test_minima_and_climbs_are_those_of_a_plain_loop(kernel):
    net = scattered(60, seed=3, kernel=kernel)
    problem = reduce(net)
    x = np.random.default_rng(0).random(60)
    y = problem.pack(x)
    x[net.sources] = net.source_values
    values = net.arcs(x[net.indices])
    expected = [values[problem.arc_ids[problem.owners == row]].min() for row in range(problem.n_rows)]
    assert np.array_equal(problem.parent_values(y), expected)
    hops = np.concatenate([problem.hops, np.zeros(len(net.sources), dtype=int)])
    for k in range(1, problem.most_hops + 1):
        down = [
            min(
                float(problem.arcs.take(np.array([a]))(np.array([0.3]))[0])
                for a in np.flatnonzero(problem.owners == row)
                if hops[problem.heads[a]] == k - 1
            )
            for row in np.flatnonzero(problem.hops == k)
        ]
        assert problem.climb(k, 0.3) == pytest.approx(max(down), rel=1e-12)


def test_unpacking_puts_back_and_marks_the_rest():
    problem = reduce(CUT_OFF)
    x = problem.unpack(problem.pack(np.arange(6.0)))
    assert x.tolist() == [0.0, 1.0, 2.0, np.inf, np.inf, 5.0]


def test_states_are_one_finite_number_per_node():
    problem = reduce(CUT_OFF)
    field(problem, np.array([0.0, 1, 2, np.nan, np.inf, 5]), "x0")
    with pytest.raises(AssumptionError, match="shape"):
        field(problem, np.zeros(5), "x0")
    with pytest.raises(AssumptionError, match=r"x0\[2\] is nan"):
        field(problem, np.array([0, 1, np.nan, 0, 0, 5]), "x0")
