"""What fails a second look is removed once, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from planner import gabf
from planner.search.healing import HealingNetwork, warm_start
from planner.search.network import build_network
from tests.worlds import make_post, post_roadmap


@pytest.fixture
def healing() -> HealingNetwork:
    roadmap = post_roadmap()
    return HealingNetwork(make_post(), roadmap, build_network(roadmap, 0.5))


def cheapest(healing: HealingNetwork) -> np.ndarray:
    network = healing.layered.network
    return gabf.extract_path(network, gabf.oracle(network), int(healing.layered.starts[0]))


def test_a_free_path_is_accepted_and_nothing_is_removed(healing: HealingNetwork) -> None:
    edges = len(healing.roadmap.edges)
    assert healing.accepts(cheapest(healing))
    assert (healing.edges_removed, len(healing.roadmap.edges)) == (0, edges)


def test_an_edge_that_fails_goes_from_roadmap_and_network(
    healing: HealingNetwork, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps = cheapest(healing)
    bad = {int(steps[0]), int(steps[1])}
    first_bad = lambda self, edges: next((k for k, edge in enumerate(edges) if set(edge) == bad), len(edges))  # noqa: E731
    monkeypatch.setattr(HealingNetwork, "_first_contact", first_bad)
    edges = len(healing.roadmap.edges)
    assert not healing.accepts(steps)
    assert (healing.edges_removed, len(healing.roadmap.edges)) == (1, edges - 1)
    assert len(healing.layered.network.arcs_between(int(steps[0]), int(steps[1]))) == 0
    assert healing.accepts(cheapest(healing))


def test_a_warm_start_is_the_current_x_raised_where_an_arc_is_gone_but_for_laws_that_need_more() -> None:
    network = build_network(post_roadmap(), 0.5)
    settled = gabf.solve(network, law=gabf.SingularityFree())
    np.testing.assert_array_equal(warm_start(network, settled, gabf.SingularityFree()), settled.x)
    steps = gabf.extract_path(network, settled, int(np.argmax(np.where(np.isfinite(settled.x), settled.x, 0.0))))
    less = network.without_arcs(network.arcs_between(int(steps[0]), int(steps[1])))
    warm = warm_start(less, settled, gabf.SingularityFree())
    assert warm is not None
    assert (warm >= gabf.oracle(less) - 1e-12).all()
    assert warm[steps[0]] > settled.x[steps[0]]
    assert warm_start(network, settled, gabf.PrescribedTime()) is None
    assert warm_start(network, None, gabf.SingularityFree()) is None
