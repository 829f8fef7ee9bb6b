"""The result of each edge's proof, kept while a roadmap grows: the clearance and the number of samples."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from planner.base.arrays import Floats, Ints, row_bytes
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import PROOF
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver, Proofs


class RecordingProver(EdgeProver):
    """A prover that remembers every free segment's clearance and samples, so that no proof is repeated to get them.

    prover = RecordingProver(checker)
    growth = grow(prover, ...)
    clearance, samples = prover.certificates(growth.nodes, growth.edges)
    """

    def __init__(self, checker: CollisionChecker, progress: Progress = QUIET) -> None:
        super().__init__(checker, progress)
        self._known: dict[tuple[bytes, bytes], tuple[float, int]] = {}

    def prove(self, start: Floats, delta: Floats, room: float = PROOF, contacts: bool = True) -> Proofs:
        """See :class:`planner.collision.edge_prover.EdgeProver`."""
        start, delta = np.atleast_2d(start), np.atleast_2d(delta)
        proofs = super().prove(start, delta, room, contacts)
        free = proofs.free
        self._note(start[free], delta[free], proofs.clearance[free], proofs.samples[free])
        return proofs

    def _note(self, start: Floats, delta: Floats, clearance: Floats, samples: Ints) -> None:
        results = zip(clearance.tolist(), samples.tolist(), strict=True)
        self._known |= dict(zip(zip(row_bytes(start), row_bytes(delta), strict=True), results, strict=True))

    def note_pieces(self, path: Floats, rows: Floats, parts: Ints) -> None:
        """The certificate of each motion of the path holds for every piece of it, see :class:`EdgeProver`."""
        whole = self._recall(path[:-1], path[1:])
        for key, motion in zip(self._keys(rows[:-1], rows[1:]), np.repeat(np.arange(len(parts)), parts), strict=True):
            if (known := whole[motion]) is not None:
                self._known.setdefault(key, known)

    def certificates(self, nodes: Floats, edges: Ints) -> tuple[Floats, Ints]:
        """Clearance (m,) metres beyond the margin, never negative, and samples (m,) of proven ``edges`` (m, 2).

        Pieces of a motion that was proven as a whole have what is known of that, see :meth:`note_pieces`, or are proven
        on their own; where that leaves one undecided nothing is claimed for it: clearance 0, no samples.
        """
        a, b = nodes[edges[:, 0]], nodes[edges[:, 1]]
        certificates = self._recall(a, b)
        if missing := _missing(certificates):  # the proof began at the other end
            for row, known in zip(missing, self._recall(b[missing], a[missing]), strict=True):
                certificates[row] = known
        if missing := _missing(certificates):
            self.free(a[missing], self.robot.difference(a[missing], b[missing]))
            for row, known in zip(missing, self._recall(a[missing], b[missing]), strict=True):
                certificates[row] = known
        clearance, samples = np.array([known or (0.0, 0) for known in certificates], dtype=float).reshape(-1, 2).T
        return np.maximum(clearance, 0.0), samples.astype(np.int64)

    def _recall(self, a: Floats, b: Floats) -> list[tuple[float, int] | None]:
        return [self._known.get(key) for key in self._keys(a, b)]

    def _keys(self, a: Floats, b: Floats) -> Iterator[tuple[bytes, bytes]]:
        return zip(row_bytes(a), row_bytes(self.robot.difference(a, b)), strict=True)


def _missing(found: list[tuple[float, int] | None]) -> list[int]:
    return [row for row, known in enumerate(found) if known is None]
