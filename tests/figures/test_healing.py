"""The pictures of a healing field: a panel per moment, red rims where x is not yet what it will be, lost edges red."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import to_hex

from planner import figures, gabf
from planner.search.network import build_network
from tests import worlds
from tests.figures.panels import lines


def test_every_moment_has_a_panel_with_its_own_rims() -> None:
    roadmap = worlds.post_roadmap()
    network = build_network(roadmap, 1.0)
    before = gabf.oracle(network)
    i, j = roadmap.edges[5].tolist()
    cut = network.without_arcs(np.concatenate([network.arcs_between(i, j), network.arcs_between(j, i)]))
    after = gabf.oracle(cut)
    nowhere = np.full(len(after), np.inf)
    moments = {"before": before, "half way": 0.5 * (before + after), "after": after, "cut off": nowhere}
    path = roadmap.nodes[:3]
    lost = np.array([5])
    world = worlds.make_post()
    figure = figures.configuration_space(world, roadmap, moments, path, settled=after, lost=lost, resolution=11)
    panels = [axes for axes in figure.axes if axes.get_title()]
    assert [axes.get_title() for axes in panels] == list(moments)
    moved = int((~np.isclose(before, after)).sum())
    for axes, rims in zip(panels, (moved, moved, 0, 0), strict=True):
        scatters: list[Any] = [c for c in axes.collections if type(c).__name__ == "PathCollection"]
        assert [len(each.get_offsets()) for each in scatters[:-1]] == [rims] * bool(rims)
        assert scatters[-1].get_clim() == (0.0, max(before.max(), after.max())), "all panels are shaded alike"
        edges: list[Any] = [c for c in axes.collections if type(c).__name__ == "LineCollection"]
        assert [len(c.get_segments()) for c in edges] == [len(roadmap.edges) - 1, 1]
        assert to_hex(edges[1].get_colors()[0]) == "#c8102e"
    np.testing.assert_array_equal(lines(panels[-1])["path"].T, path)
