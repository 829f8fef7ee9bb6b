"""The non-dominated paths of small random graphs, by enumeration of all simple paths; stops and refusals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.base.errors import AssumptionError, OptionError
from planner.base.progress import Progress
from planner.tradeoff.nondominated import Front, non_dominated
from tests.random_shapes import QUICK
from tests.tradeoff.graphs import Graph, enumerated_front, random_graph


def least_costs(graph: Graph) -> np.ndarray:
    """(n, 2) least costs to a goal, by Bellman-Ford."""
    tails = np.repeat(np.arange(graph.nodes), np.diff(graph.indptr))
    bounds = np.full((graph.nodes, 2), np.inf)
    for _ in range(graph.nodes):
        bounds[graph.goals] = 0.0
        np.minimum.at(bounds, tails, graph.costs + bounds[graph.heads])
    bounds[graph.goals] = 0.0
    return bounds


def search(graph: Graph, bounds: np.ndarray | None = None, **more: Any) -> Front:
    bounds = least_costs(graph) if bounds is None else bounds
    return non_dominated(graph.indptr, graph.heads, graph.costs, graph.starts, graph.goals, bounds, **more)


@QUICK
@given(st.integers(0, 2**31), st.integers(5, 11), st.floats(0.4, 1.0), st.sampled_from([None, 3, 12]))
def test_the_front_is_that_of_all_simple_paths(seed: int, nodes: int, share: float, levels: int | None) -> None:
    graph = random_graph(seed, nodes, share, levels)
    front = search(graph)
    assert front.complete
    wanted = np.array(enumerated_front(graph), dtype=float).reshape(-1, 2)
    assert front.points.shape == wanted.shape
    np.testing.assert_allclose(front.points, wanted, rtol=1e-12)
    for path, point in zip(front.paths, front.points, strict=True):
        assert path[0] in graph.starts
        assert path[-1] in graph.goals
        np.testing.assert_allclose(graph.cost(path), point, rtol=1e-12)


def test_enough_of_these_graphs_have_a_front_worth_the_name() -> None:
    sizes = np.array([len(search(random_graph(seed, 11, 0.6, None)).points) for seed in range(40)])
    assert (sizes >= 3).sum() >= 15
    assert sizes.max() >= 5
    assert sizes.min() == 0


def ladder(rungs: int) -> Graph:
    """A chain in which every step goes one of two ways, 2^k cheaper in one cost or in the other: 2^rungs paths, all
    of them non-dominated."""
    indptr, heads, costs = [0], [], []
    for k in range(rungs):
        heads += [3 * k + 1, 3 * k + 2]
        costs += [[2.0**k, 1.0], [1.0, 2.0**k]]
        indptr.append(len(heads))
        for _ in range(2):
            heads.append(3 * k + 3)
            costs.append([1.0, 1.0])
            indptr.append(len(heads))
    indptr.append(len(heads))
    return Graph(np.array(indptr), np.array(heads), np.array(costs), np.array([0]), np.array([3 * rungs]))


def test_a_front_that_grows_exponentially_is_cut_where_the_labels_end() -> None:
    graph = ladder(11)
    whole = search(graph)
    assert whole.complete
    assert len(whole.points) == 2**10  # the first step makes no difference
    cut = search(graph, max_labels=whole.labels // 2)
    assert not cut.complete
    assert 0 < len(cut.points) < len(whole.points)
    # what there is are the points of least Omega
    np.testing.assert_array_equal(cut.points, whole.points[: len(cut.points)])
    assert cut.labels <= whole.labels // 2 + 2
    assert search(graph, max_labels=whole.labels + 1).complete


def test_progress_and_stop() -> None:
    graph, heard = ladder(11), []
    whole = search(graph, progress=Progress(lambda *word: heard.append(word)))
    assert [stage for stage, _, _ in heard] == ["front"] * len(heard)
    assert [done for _, done, _ in heard] == sorted(done for _, done, _ in heard)
    assert heard[-1][1:] == (whole.labels, whole.labels)
    asked = iter([False, True])
    cut = search(graph, progress=Progress(stop=lambda: next(asked)))
    assert not cut.complete
    assert len(cut.points) < len(whole.points)


def test_no_way_to_a_goal_gives_an_empty_complete_front() -> None:
    graph = replace(ladder(3), starts=np.array([9]), goals=np.array([0]))
    front = search(graph)
    assert front.points.shape == (0, 2)
    assert front.paths == ()
    assert front.complete


def test_a_start_that_is_a_goal_costs_nothing() -> None:
    front = search(replace(ladder(3), starts=np.array([0, 9])))
    assert front.points.tolist() == [[0.0, 0.0]]
    assert front.paths[0].tolist() == [9]


def test_refusals() -> None:
    graph = ladder(3)
    with pytest.raises(OptionError, match="0 labels make no search: give a whole number from 1"):
        search(graph, max_labels=0)
    with pytest.raises(AssumptionError, match="must not be negative"):
        search(replace(graph, costs=-graph.costs))
    bounds = least_costs(graph)
    bounds[3, 0] += 5.0
    with pytest.raises(AssumptionError, match=r"bound at node 3 exceeds that at node \d by more than the arc"):
        search(graph, bounds)
