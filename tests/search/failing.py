"""A second look that sees contacts where a test wants them."""

import numpy as np
import pytest

import planner.search.search as module
from planner.collision.recheck import PathContact
from planner.collision.world import Contact
from planner.roadmap.roadmap import Roadmap


def collide(monkeypatch: pytest.MonkeyPatch, roadmap: Roadmap, edges: np.ndarray) -> list[tuple[int, int]]:
    """The second look finds a contact on these ``edges`` (k, 2) of a roadmap; returns those that it has found."""
    real, found = module.recheck_pieces, []
    ends = [(roadmap.nodes[i], roadmap.nodes[j], (int(i), int(j))) for i, j in edges]

    def look(checker, pieces, progress):
        for row, (start, delta) in enumerate(pieces):
            for a, b, edge in ends:
                for p, q in ((a, b), (b, a)):
                    if np.allclose(start, p, atol=1e-12) and np.allclose(start + delta, q, atol=1e-9):
                        found.append(edge)
                        return PathContact(row, 0.0, start, Contact("link_2", "post"))
        return real(checker, pieces)

    monkeypatch.setattr(module, "recheck_pieces", look)
    return found
