"""The nine-node example."""

import numpy as np
import pytest

from planner import gabf

from .networks import solve


def test_the_nine_node_example_is_what_the_text_says():
    """Section 2, in the paper's numbering: node k is index k - 1."""
    net = gabf.examples.nine_node()
    found = gabf.structure(net)
    assert found.x_star[[0, 8]].tolist() == [1.0, 1.0]
    assert found.x_star[3] == 7.0
    assert (gabf.true_parents(net, found, 3) + 1).tolist() == [2, 3]
    assert found.diameter == 3
    assert found.x_star[5] == 7.0
    assert (gabf.true_parents(net, found, 5) + 1).tolist() == [8, 9]
    assert found.longest[5] == 2
    assert found.fewest[5] == 1
    assert (np.flatnonzero(found.longest == 0) + 1).tolist() == [1, 9]
    assert gabf.true_parents(net, found, 0).size == 0
    assert net.n_nodes == 9
    assert (net.weight < 0).any()


@pytest.mark.parametrize("law", [gabf.Nominal(), gabf.PrescribedTime(), gabf.FixedTime(), gabf.SingularityFree()])
def test_every_law_solves_the_nine_node_example(law):
    result = solve(gabf.examples.nine_node(), law)
    assert result.x.tolist() == [1, 3, 3, 7, 5, 7, 4, 3, 1]
