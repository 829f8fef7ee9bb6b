"""The lower envelope on small random graphs, by enumeration in exact fractions; ties, stops, laws and kernels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner import gabf
from planner.base.errors import AssumptionError
from planner.search.network import arc_costs, at_beta
from planner.search.search import ProvenNetwork
from planner.tradeoff.envelope import EnvelopeSearch, SupportInterval, support_intervals
from tests.random_shapes import QUICK
from tests.tradeoff.graphs import Graph, enumerated_envelope, random_graph

LAWS = [gabf.Nominal(), gabf.PrescribedTime(T=2.0), gabf.FixedTime(), gabf.SingularityFree(T=2.0)]


def searched(graph: Graph, law: gabf.Law | None = None) -> EnvelopeSearch:
    search = EnvelopeSearch(ProvenNetwork(graph.network(), graph.starts), law or gabf.SingularityFree(T=4.0))
    while not search.is_done:
        search.step()
    return search


def lines(found: list[SupportInterval]) -> np.ndarray:
    """(k, 2) Omega and D."""
    return np.array([(piece.support.manipulability, piece.support.distance) for piece in found]).reshape(-1, 2)


@QUICK
@given(st.integers(0, 2**31), st.integers(5, 11), st.floats(0.4, 1.0), st.sampled_from([None, 3, 12]))
def test_the_envelope_is_that_of_all_simple_paths(seed: int, nodes: int, share: float, levels: int | None) -> None:
    graph = random_graph(seed, nodes, share, levels)
    search = searched(graph)
    wanted, corners = enumerated_envelope(graph)
    assert search.is_connected == bool(wanted)
    found = support_intervals(search.supports)
    assert len(found) == len(wanted)
    np.testing.assert_allclose(lines(found), np.array(wanted, dtype=float).reshape(lines(found).shape), rtol=1e-12)
    np.testing.assert_allclose([piece.beta_min for piece in found[1:]], np.array(corners, dtype=float), atol=1e-12)
    for piece in found:
        support = piece.support
        assert support.nodes[0] in graph.starts
        assert support.nodes[-1] in graph.goals
        np.testing.assert_allclose(graph.cost(support.nodes), [support.manipulability, support.distance], rtol=1e-12)


@QUICK
@given(st.integers(0, 2**31), st.sampled_from([None, 3]))
def test_pieces_cover_everything_once_and_hold_their_field(seed: int, levels: int | None) -> None:
    graph = random_graph(seed, 11, 0.7, levels)
    search = searched(graph)
    if not search.is_connected:
        return
    found = support_intervals(search.supports)
    assert [found[0].beta_min, found[-1].beta_max] == [0.0, 1.0]
    assert [piece.beta_max for piece in found[:-1]] == [piece.beta_min for piece in found[1:]]
    for piece in found:
        field = piece.support.cost_to_go
        assert field is not None
        assert piece.beta_min < piece.beta_max
        assert piece.beta_min <= piece.support.beta <= piece.beta_max
        np.testing.assert_array_equal(field.x, gabf.oracle(graph.network(piece.support.beta)))
        assert piece.support.at(piece.support.beta) == pytest.approx(field.x[graph.starts].min(), rel=1e-12)
    assert search.max_error == 0.0
    assert search.solves <= 2 * len(search.supports) + 1


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_every_law_finds_the_same(law: gabf.Law) -> None:
    graph = random_graph(5, 60, 0.6, None)
    plain, other = support_intervals(searched(graph).supports), support_intervals(searched(graph, law).supports)
    assert len(plain) >= 8
    np.testing.assert_array_equal(lines(plain), lines(other))
    assert [piece.beta_max for piece in plain] == [piece.beta_max for piece in other]


# ties, by hand


def fan(*paths: tuple[float, float]) -> Graph:
    """From node 0 by one of the nodes 1, 2, ... to the goal, at these costs; the lower number wins a tie."""
    k = len(paths)
    heads = np.array([*range(1, k + 1), *[k + 1] * k])
    costs = np.array([(omega - 0.5, distance - 0.5) for omega, distance in paths] + [(0.5, 0.5)] * k)
    indptr = np.array([0, *range(k, 2 * k + 1), 2 * k])
    return Graph(indptr, heads, costs, np.array([0]), np.array([k + 1]))


@pytest.mark.parametrize(
    ("detour", "wanted"),
    [
        ((2.0, 2.0), [(1.0, 4.0), (2.0, 2.0), (4.0, 1.0)]),
        ((2.5, 2.5), [(1.0, 4.0), (4.0, 1.0)]),  # touches the envelope at its corner only
        ((3.0, 3.0), [(1.0, 4.0), (4.0, 1.0)]),  # above it
        ((1.0, 3.0), [(1.0, 3.0), (4.0, 1.0)]),  # as little Omega for less D
        ((3.0, 1.0), [(1.0, 4.0), (3.0, 1.0)]),  # the reverse
        ((4.0, 1.0), [(1.0, 4.0), (4.0, 1.0)]),  # another path of equal line
        ((1.0, 1.0), [(1.0, 1.0)]),  # better in both
    ],
)
def test_ties(detour: tuple[float, float], wanted: list[tuple[float, float]]) -> None:
    found = support_intervals(searched(fan((1.0, 4.0), (4.0, 1.0), detour)).supports)
    assert lines(found).tolist() == [list(line) for line in wanted]


# half-way


def test_what_is_settled_reaches_from_the_left() -> None:
    graph = random_graph(5, 60, 0.6, None)
    whole = support_intervals(searched(graph).supports)
    search, reached = EnvelopeSearch(ProvenNetwork(graph.network(), graph.starts), gabf.SingularityFree()), [0.0]
    while not search.is_done:
        search.step()
        assert search.reach >= reached[-1]
        reached.append(search.reach)
        proven = support_intervals(search.supports[: search.settled + 1])[:-1]
        assert [piece.beta_max for piece in proven] == [piece.beta_max for piece in whole[: len(proven)]]
        np.testing.assert_array_equal(lines(proven), lines(whole[: len(proven)]))
    assert reached[-1] == 1.0


# kernels


def test_arc_costs_are_what_the_kernel_charges() -> None:
    graph = random_graph(3, 10, 0.8, None)
    at_nodes = graph.network()
    inside = gabf.Network(
        graph.indptr, graph.heads, graph.costs[:, 1], graph.goals, arc_cost=graph.costs[:, 0],
        kernel=gabf.EdgeIntegral(0.3),
    )  # fmt: skip
    for network in (at_nodes, inside):
        np.testing.assert_array_equal(arc_costs(network), graph.costs)
        np.testing.assert_array_equal(
            at_beta(network, 0.25).arcs(np.zeros(network.n_arcs)), 0.75 * graph.costs[:, 0] + 0.25 * graph.costs[:, 1]
        )
    plain = gabf.Network(graph.indptr, graph.heads, graph.costs[:, 1], graph.goals, kernel=gabf.Additive())
    with pytest.raises(AssumptionError, match="the kernel must be TradeOff or EdgeIntegral, got Additive"):
        at_beta(plain, 0.5)
