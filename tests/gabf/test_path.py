import numpy as np

from planner import gabf

from .networks import from_arcs, scattered, solve


def test_ties_go_to_fewer_hops_then_to_smaller_indices():
    net = from_arcs(6, [(5, 4, 1.0), (5, 3, 1.0), (5, 1, 2.0), (4, 2, 1.0), (3, 2, 1.0), (2, 0, 1.0), (1, 0, 1.0)])
    assert gabf.extract_path(net, gabf.oracle(net), 5).tolist() == [5, 1, 0]
    net = net.without_arcs(net.arcs_between(5, 1))
    assert gabf.extract_path(net, gabf.oracle(net), 5).tolist() == [5, 3, 2, 0]


def test_no_node_repeats_where_costs_vanish_in_rounding():
    big = 1e9
    net = from_arcs(
        4, [(1, 0, big), (2, 1, 1e-9), (1, 2, 1e-9), (3, 2, 1e-9), (2, 3, 1e-9), (3, 1, 1e-9), (1, 3, 1e-9)]
    )
    result = solve(net)
    assert result.x[1] == result.x[2] == result.x[3] == big
    assert gabf.extract_path(net, result, 2).tolist() == [2, 1, 0]
    assert gabf.extract_path(net, result, 3).tolist() == [3, 1, 0]


def test_a_nearly_settled_field_still_gives_the_path():
    net = scattered(60, seed=5)
    x = gabf.oracle(net)
    start = int(np.argmax(np.where(np.isfinite(x), x, -1)))
    noisy = x + np.random.default_rng(0).uniform(-1e-12, 1e-12, 60)
    assert gabf.extract_path(net, noisy, start).tolist() == gabf.extract_path(net, x, start).tolist()
