"""What it took to answer once more in a world that had changed."""

from __future__ import annotations

from dataclasses import astuple, dataclass


@dataclass(frozen=True)
class Edges:
    """What became of a roadmap's edges in one call.

    ``proven`` anew by a check; ``removed``: they were free and a proof failed; ``regained``: they were blocked and are
    free; ``opened``: they were free, and have to be proven again before a path uses them.
    """

    proven: int = 0
    removed: int = 0
    regained: int = 0
    opened: int = 0

    def __add__(self, other: Edges) -> Edges:
        return Edges(*(a + b for a, b in zip(astuple(self), astuple(other), strict=True)))


@dataclass(frozen=True)
class Change:
    """A change of the world: what happened, in words, and what it meant for the edges; ``seconds`` it took."""

    what: str
    edges: Edges
    seconds: float


@dataclass(frozen=True)
class Replanned:
    """What a session did for a plan: ``edges`` that it proved, and how its field healed.

    ``raised`` counts the nodes that were lifted on the way, ``updates`` the parent values that were computed,
    ``rounds`` how often it healed. ``nodes_grown``: by how many nodes the roadmap grew because start and goal had come
    apart.
    """

    edges: Edges = Edges()
    nodes_grown: int = 0
    rounds: int = 0
    raised: int = 0
    updates: int = 0
