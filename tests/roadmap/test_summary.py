"""What a roadmap says of itself, counted again from its arrays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planner.roadmap.summary import summary
from tests.worlds import post_roadmap


def test_counts_are_those_of_the_arrays() -> None:
    roadmap = post_roadmap()
    unproven = roadmap.proven.copy()
    unproven[:3] = False
    some = replace(roadmap, proven=unproven, clearance=np.where(unproven, roadmap.clearance, 99.0))
    told = summary(some)
    neighbours = [sum(node in edge for edge in some.edges.tolist()) for node in range(len(some.nodes))]
    assert told["degree"] == {"min": min(neighbours), "mean": np.mean(neighbours), "max": max(neighbours)}
    assert told["edges_certified"] == len(some.edges) - 3
    assert told["clearance"]["max"] == some.clearance[3:].max() < 99.0  # what has no proof promises nothing
    assert sum(told["components"]) == len(some.nodes)
    assert told["components"] == sorted(told["components"], reverse=True)
    assert told["manipulability"]["0"] == some.manipulability.min()
    assert told["manipulability"]["1"] == some.manipulability.max()


def test_a_roadmap_without_edges_or_with_nothing_to_touch_has_no_numbers_for_them() -> None:
    roadmap = post_roadmap()
    free = replace(roadmap, clearance=np.full(len(roadmap.edges), np.inf))
    assert summary(free)["clearance"] == {"min": None, "median": None, "max": None}
    m = 0
    bare = replace(
        roadmap,
        edges=roadmap.edges[:m],
        proven=roadmap.proven[:m],
        joint_length=roadmap.joint_length[:m],
        tool_length=roadmap.tool_length[:m],
        edge_manipulability=roadmap.edge_manipulability[:m],
        clearance=roadmap.clearance[:m],
        samples=roadmap.samples[:m],
    )
    assert summary(bare)["joint_length"]["max"] is None
    assert not summary(bare)["connected"]
    assert "none" in bare._repr_html_()
    assert bare.record().text.endswith(f"{len(bare.nodes)} components")
