"""The same lines put to HPP's continuous validation, which proves too; it knows of no limits and no stops."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.gate.chunks import Chunk
from benchmarks.others import solver_runner
from benchmarks.others.elsewhere import answer_of
from benchmarks.others.exchange import exchanged
from planner.query.query import Query
from planner.session.gate import Gate

_WAIT = 600.0  # s


def proven_by_hpp(python: str, gate: Gate, chunks: Sequence[Chunk]) -> tuple[int, float]:
    """How many pieces of chunks of lines HPP's Dichotomy proves without a tolerance, and the seconds of all."""
    if not chunks:
        return 0, 0.0
    ends = chunks[0].knots[[0, -1], 0]
    asked = exchanged(Query(gate.robot, gate.scene, gate.checker, ends[:1], ends[1:], ("end",)), 0, 0.0)
    rows = [chunk.knots[:, 0] for chunk in chunks]
    asked["motions"] = [[a, b] for row in rows for a, b in zip(row.tolist(), row[1:].tolist(), strict=False)]
    found = answer_of("HPP", python, solver_runner.__file__, asked, _WAIT, ["hpp proofs"])
    return sum(found["Dichotomy"]), found["Dichotomy_s"]
