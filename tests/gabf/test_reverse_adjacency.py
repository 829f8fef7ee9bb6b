"""The arcs that read a node, against a look at every arc."""

import numpy as np

from planner.gabf.reverse_adjacency import Readers

from .networks import scattered


def test_arcs_that_read_nodes_are_those_with_such_a_head():
    net, nodes = scattered(50), np.array([3, 17])
    assert sorted(Readers(net.indices, 50).of(nodes)) == np.flatnonzero(np.isin(net.indices, nodes)).tolist()
    assert Readers(net.indices, 50).of(np.zeros(0, dtype=np.int64)).size == 0
