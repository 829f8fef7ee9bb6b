import numpy as np
import pytest

from planner import gabf
from planner.gabf import bounds

from .networks import chain, from_arcs, scattered


def test_levels_are_the_distinct_values_and_longest_paths_follow_true_parents():
    net = scattered(90, seed=7)
    found = gabf.structure(net)
    rows = np.flatnonzero(found.longest > 0)
    assert np.unique(np.round(found.x_star[rows], 10)).size == found.R
    assert np.allclose(found.values[found.level[rows]], found.x_star[rows])
    for i in rows:
        parents = gabf.true_parents(net, found, int(i))
        assert parents.size
        assert found.longest[i] == 1 + found.longest[parents].max()
        assert found.fewest[i] == 1 + found.fewest[parents].min()
        assert (found.level[parents] < found.level[i]).all()
    assert found.diameter == found.longest.max() + 1


def test_paths_that_tie_up_to_rounding_count_as_ties():
    net = from_arcs(4, [(1, 0, 0.1), (2, 1, 0.2), (3, 2, 0.3), (3, 0, 0.6)])
    found = gabf.structure(net)
    assert 0.1 + 0.2 + 0.3 != 0.6
    assert gabf.true_parents(net, found, 3).tolist() == [0, 2]
    assert (found.longest[3], found.fewest[3]) == (3, 1)


@pytest.mark.parametrize(("far", "near"), [(1.0, 9e-13), (1e6, 9e-7), (0.5, 1e-15)])
def test_a_chain_of_tiny_arcs_has_as_many_levels_as_arcs(far, near):
    costs = [far] + [near] * 10
    found = gabf.structure(from_arcs(12, [(i + 1, i, cost) for i, cost in enumerate(costs)]))
    assert found.R == len(costs) == len(set(np.cumsum(costs)))
    assert found.level.tolist() == list(range(12))


def test_small_values_are_no_ties():
    found = gabf.structure(chain(5, 1e-20))
    assert (found.diameter, found.R) == (5, 4)


def test_a_chain_is_one_path():
    found = gabf.structure(chain(5))
    assert (found.diameter, found.R) == (5, 4)
    assert found.longest.tolist() == found.fewest.tolist() == found.level.tolist() == [0, 1, 2, 3, 4]


def test_log_alpha_is_the_maximum_that_theorem_exponential_defines():
    for diameter in (2, 3, 4, 9, 50):
        k = np.arange(diameter - 1)
        alpha = [(i / (0.5 * np.e)) ** i for i in k]
        assert bounds.log_alpha(diameter) == pytest.approx(np.log(max(alpha)), abs=1e-12)
    assert np.isfinite(bounds.log_alpha(100_000))
