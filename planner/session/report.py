"""What a change of a session's world hands back."""

from __future__ import annotations

from dataclasses import dataclass

from planner.planning.replanned import Edges
from planner.session.edge_proofs import EdgeProofs


@dataclass(frozen=True)
class Change:
    """A change of the world: what happened, in words, and what it meant for the edges; ``seconds`` it took."""

    what: str
    edges: Edges
    seconds: float


def edges_between(before: EdgeProofs, after: EdgeProofs, checked: bool = True) -> Edges:
    """From one moment to a later one, for the same edges; not ``checked``: what was not decided was forgotten."""
    return Edges(
        proven=int((before.open & after.free).sum()) if checked else 0,
        removed=int((~before.lost & after.lost).sum()),
        regained=int((before.lost & ~after.lost).sum()),
        opened=int((before.free & after.open).sum()),
    )
