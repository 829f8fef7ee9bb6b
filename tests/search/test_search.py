"""The search: its path is Dijkstra's on the remaining arcs, for any failing edges and any start of the field."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner import gabf
from planner.search.network import build_network
from planner.search.search import RoadmapPaths, SearchResult, make_recheck, search
from tests.random_shapes import QUICK
from tests.search.failing import collide
from tests.worlds import make_post, post_roadmap

LAWS = [gabf.SingularityFree(), gabf.Nominal(), gabf.FixedTime(), gabf.PrescribedTime(T=2.0)]


class Graph:
    """Random arcs, some of which are bad; the first bad one of a path fails, and the others of its tail with it."""

    def __init__(self, seed: int, nodes: int, share: float, around: bool) -> None:
        rng = np.random.default_rng(seed)
        tails, heads = np.nonzero((rng.random((nodes, nodes)) < 0.4) & ~np.eye(nodes, dtype=bool))
        weight = rng.uniform(0.1, 1.0, len(tails))
        kernel = gabf.Additive()
        self.whole = gabf.Network.from_arcs(tails, heads, weight, np.array([nodes - 1]), nodes, kernel=kernel)
        self.bad = rng.random(len(tails)) < share
        self.gone, self.around = np.zeros(len(tails), dtype=bool), around
        self.starts = np.array([0, 1])

    @property
    def network(self) -> gabf.Network:
        return self.whole.without_arcs(np.flatnonzero(self.gone))

    def prove_path(self, steps: np.ndarray) -> bool:
        arcs = self.whole.arcs_along(steps)
        failed = arcs[self.bad[arcs]]
        self.gone[failed[:1]] = True
        if self.around and len(failed):
            self.gone |= self.bad & (self.whole.tails == self.whole.tails[failed[0]])
        return not len(failed)


def cost_of(graph: Graph, found: SearchResult) -> float:
    return float(graph.whole.weight[graph.whole.arcs_along(found.steps)].sum())


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
@QUICK
@given(st.integers(0, 2**31), st.integers(3, 14), st.floats(0.0, 0.8), st.booleans(), st.booleans())
def test_the_path_is_the_cheapest_of_all_good_ones(law, seed, nodes, share, around, warm) -> None:
    graph = Graph(seed, nodes, share, around)
    before = np.random.default_rng(seed).uniform(0.0, 3.0, nodes - 1) if warm else None  # one node is new
    found = search(graph, law, before)
    good = graph.whole.without_arcs(np.flatnonzero(graph.bad))
    best = gabf.oracle(good)[graph.starts].min()
    assert len(found.steps) > 0 or np.isinf(best)
    if len(found.steps):
        assert cost_of(graph, found) == pytest.approx(best, rel=1e-9)
        assert not graph.bad[graph.whole.arcs_along(found.steps)].any()
    left = gabf.oracle(graph.network)  # the field is that of what is left
    np.testing.assert_allclose(found.field.x, left, rtol=1e-9)
    assert not (graph.gone & ~graph.bad).any()


def post_paths(floor: float = 0.0, seen: set[bytes] | None = None) -> RoadmapPaths:
    roadmap, checker = post_roadmap(), make_post()
    look = make_recheck(checker, roadmap, seen)
    return RoadmapPaths(roadmap, checker.robot, build_network(roadmap, 0.5), floor, look)


def test_only_the_edges_that_fail_go_from_roadmap_and_network(monkeypatch: pytest.MonkeyPatch) -> None:
    roadmap, first = post_roadmap(), search(post_paths(), gabf.SingularityFree()).steps
    bad = np.sort(np.stack([first[:-1], first[1:]], axis=1), axis=1)
    failures = collide(monkeypatch, roadmap, bad)
    paths = post_paths()
    found = search(paths, gabf.SingularityFree())
    assert len(failures) == (~paths.kept).sum() == len(roadmap.edges) - len(paths.roadmap.edges) >= 1
    assert {tuple(edge) for edge in roadmap.edges[~paths.kept].tolist()} <= {tuple(edge) for edge in bad.tolist()}
    assert not set(itertools.pairwise(found.steps.tolist())) & {tuple(edge) for edge in bad.tolist()}
    fresh = gabf.oracle(build_network(paths.roadmap, 0.5))
    np.testing.assert_allclose(found.field.x, fresh, rtol=1e-9)


def test_an_edge_that_passed_a_second_look_is_not_checked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: set[bytes] = set()
    steps = search(post_paths(seen=seen), gabf.SingularityFree()).steps
    assert len(seen) == len(steps) - 1
    monkeypatch.setattr(
        "planner.search.search.recheck_pieces", lambda checker, pieces, progress: pytest.fail(f"{len(pieces)} more")
    )
    assert post_paths(seen=seen).prove_path(steps[::-1])
