"""The random graphs of section (comparison)."""

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import AssumptionError, OptionError
from reproduce.laws import graphs as random_graphs
from reproduce.laws.graphs import SIDE, START, draw_graph


@pytest.fixture(scope="module")
def graphs() -> list[random_graphs.RandomGraph]:
    return [draw_graph(np.random.default_rng([7, k]), 300) for k in range(8)]


def test_mean_out_degree_is_about_ten(graphs) -> None:
    degrees = [graph.out_degree for graph in graphs]
    # arcs are coins: the mean over 300 nodes scatters by 0.1
    assert all(9.5 < degree < 10.5 for degree in degrees)
    assert abs(np.mean(degrees) - 10.0) < 0.15


def test_every_node_reaches_the_source_and_ten_overestimates(graphs) -> None:
    for graph in graphs:
        assert np.isfinite(graph.x_star).all()
        assert graph.x_star.max() < START
        assert np.array_equal(graph.x_star, gabf.oracle(graph.network))
        gabf.solve(graph.network, law=gabf.PrescribedTime(), x0=START, max_steps=0)  # refused if it were none


def test_arcs_are_near_pairs_of_their_euclidean_length(graphs) -> None:
    for graph in graphs:
        net, position = graph.network, graph.position
        length = np.linalg.norm(position[net.tails] - position[net.indices], axis=1)
        assert np.allclose(net.weight, length)
        assert net.weight.max() <= graph.radius
        assert position.min() >= 0.0
        assert position.max() <= SIDE


def test_directions_are_thinned_independently(graphs) -> None:
    for graph in graphs:
        net = graph.network
        arcs = set(zip(net.tails.tolist(), net.indices.tolist(), strict=True))
        both = sum((j, i) in arcs for i, j in arcs) / len(arcs)
        pairs = int((np.linalg.norm(graph.position[:, None] - graph.position[None], axis=2) < graph.radius).sum()) - 300
        # an arc's reverse is there as often as any candidate is
        assert abs(both - len(arcs) / pairs) < 0.05


def test_the_source_is_the_middle_node(graphs) -> None:
    for graph in graphs:
        distance = np.linalg.norm(graph.position - SIDE / 2, axis=1)
        assert graph.source == np.argmin(distance)


def test_redraws_are_counted() -> None:
    # at 4 out-neighbours many a node is cut off
    graph = draw_graph(np.random.default_rng(0), 60, out_degree=4.0)
    assert graph.redraws >= graph.cut_off >= 1


def test_impossible_requests_are_refused_with_a_remedy() -> None:
    with pytest.raises(OptionError, match="nodes must be"):
        draw_graph(np.random.default_rng(0), 20)
    with pytest.raises(AssumptionError, match="raise the number"):
        draw_graph(np.random.default_rng(0), 60, start=1.0)
