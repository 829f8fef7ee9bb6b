"""New nodes and edges beside the old ones: numbers, proofs and margins stay those that they were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planner.roadmap.edge_certificates import RecordingProver
from planner.roadmap.enlarge import enlarged
from tests.worlds import make_post, post_roadmap


def free_pairs(prover: RecordingProver, count: int) -> np.ndarray:
    """(count, 2) nodes of the post's roadmap that a proven motion joins, without an edge between them as yet."""
    nodes, edges = post_roadmap().nodes, set(map(tuple, post_roadmap().edges.tolist()))
    pairs = np.array([(i, j) for j in range(len(nodes)) for i in range(j) if (i, j) not in edges])
    a, b = nodes[pairs[:, 0]], nodes[pairs[:, 1]]
    return pairs[prover.free(a, prover.robot.difference(a, b))][:count]


def test_edges_that_are_there_stay_and_new_ones_come_once() -> None:
    old, prover = post_roadmap(), RecordingProver(make_post())
    new = free_pairs(prover, 5)
    made = enlarged(old, prover, old.nodes[:0], np.concatenate([new, old.edges[:7], new]))
    assert sorted(map(tuple, made.edges.tolist())) == sorted(map(tuple, [*old.edges.tolist(), *new.tolist()]))
    rows = [made.edge_index(i, j) for i, j in old.edges.tolist()]
    for name in ("proven", "joint_length", "tool_length", "clearance", "samples", "edge_manipulability"):
        np.testing.assert_array_equal(getattr(made, name)[rows], getattr(old, name))
    assert made.proven.all()
    np.testing.assert_array_equal(made.edges, np.unique(made.edges, axis=0))  # sorted


@pytest.mark.parametrize("margin", [0.0, 0.01])
def test_the_margin_is_the_weaker_one_and_clearances_count_from_it(margin: float) -> None:
    old, prover = post_roadmap(), RecordingProver(make_post())
    assert prover.world.margin == 0.0
    with_margin = replace(old, origin=replace(old.origin, margin=margin))
    new = free_pairs(prover, 1)
    made = enlarged(with_margin, prover, old.nodes[:0], new)
    assert made.origin.margin == 0.0
    rows = [made.edge_index(i, j) for i, j in old.edges.tolist()]
    np.testing.assert_allclose(made.clearance[rows], old.clearance + margin, rtol=0, atol=1e-15)
    same = enlarged(old, prover, old.nodes[:0], new)
    assert made.clearance[made.edge_index(*new[0])] == same.clearance[same.edge_index(*new[0])]
