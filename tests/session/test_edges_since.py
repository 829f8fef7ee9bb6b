"""What became of edges between two moments, counted against a plain loop."""

from __future__ import annotations

import itertools

import numpy as np

from planner.planning.result import Edges
from planner.session.edge_proofs import ARM, EdgeProofs

STATES = {"free": 0.1, "open": np.nan, "blocked": -np.inf}


def edge_states(states: list[str], lost: list[bool]) -> EdgeProofs:
    known = np.array([[STATES[state]] for state in states])
    return EdgeProofs(((ARM, "a"),), known, np.array(lost), np.zeros(known.shape, bool))


def test_every_transition_is_counted_once() -> None:
    pairs = list(itertools.product(STATES, STATES))
    before = edge_states([a for a, _ in pairs], [False] * 9)
    after = edge_states([b for _, b in pairs], [a == "blocked" for a, _ in pairs])
    found = after.since(before)
    expected = Edges(
        proven=sum(a == "open" and b == "free" for a, b in pairs),
        removed=sum(a != "blocked" and b == "blocked" for a, b in pairs),
        regained=sum(a == "blocked" and b == "free" for a, b in pairs),
        opened=sum(a == "free" and b == "open" for a, b in pairs),
    )
    assert found == expected
    assert after.since(before, checked=False).proven == 0
    assert found + found == Edges(*(2 * n for n in (found.proven, found.removed, found.regained, found.opened)))
