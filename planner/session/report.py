"""What a session's calls hand back: the change that was made, and the answer to a query."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from functools import cached_property

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.planning.network import PathCost
from planner.problem.outcome import Outcome
from planner.problem.reasons import NoPath
from planner.session.edge_proofs import EdgeProofs


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

    @staticmethod
    def between(before: EdgeProofs, after: EdgeProofs, checked: bool = True) -> Edges:
        """From one moment to a later one, for the same edges; not ``checked``: what was not decided was forgotten."""
        return Edges(
            proven=int((before.open & after.free).sum()) if checked else 0,
            removed=int((~before.lost & after.lost).sum()),
            regained=int((before.lost & ~after.lost).sum()),
            opened=int((before.free & after.open).sum()),
        )


@dataclass(frozen=True)
class Change:
    """A change of the world: what happened, in words, and what it meant for the edges; ``seconds`` it took."""

    what: str
    edges: Edges
    seconds: float


@dataclass(frozen=True, eq=False)
class Answer:
    """The answer to a query, in the world as it was then; ``path`` (k, dof) rad is empty where there is none.

    ``path_nodes`` (k,) are nodes of ``session.roadmap``'s whole. ``field`` is the healed field; ``raised`` counts the
    nodes that were lifted on the way to it, ``updates`` the parent values that were computed, ``rounds`` how often it
    healed. ``nodes_grown``: by how many nodes the roadmap grew because start and goal had come apart.
    ``reason`` says why there is no path.
    """

    outcome: Outcome
    path: Floats
    path_nodes: Ints
    goal: str | None
    cost: PathCost | None
    edges: Edges
    nodes_grown: int
    rounds: int
    raised: int
    updates: int
    field: gabf.CostToGo | None
    seconds: float
    reason: NoPath | None = None

    @property
    def solved(self) -> bool:
        return self.outcome is Outcome.SOLVED

    @cached_property
    def error(self) -> float:
        """The largest error of the field against Dijkstra's answer, relative to max(1, |x*|)."""
        return 0.0 if self.field is None else gabf.max_error(self.field, gabf.oracle(self.field.network))

    @cached_property
    def certificate(self) -> tuple[gabf.Certificate, ...]:
        """Every bound of the paper that the run of the last round meets."""
        return () if self.field is None else tuple(gabf.certify(self.field.network, self.field.law, self.field))
