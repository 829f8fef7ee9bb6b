"""Where a network is cut: which block each row belongs to, and which states the blocks have to exchange."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, Ints, ranges
from planner.base.errors import OptionError
from planner.gabf.problem import Problem, Rows


@dataclass(frozen=True, eq=False)
class Partition:
    """How :func:`planner.gabf.solve` cuts a network, and where its blocks live.

    ``blocks``: how many. ``scheduler``: address of a Dask cluster whose workers hold the blocks; in this process, one
    after the other, where left out. ``assignment`` (n,): the block of each node, in place of bands of about equal arcs
    in reverse Cuthill-McKee order (E. Cuthill, J. McKee, 1969), which keeps the states to exchange few. More blocks
    need less memory each and exchange more. x does not depend on any of this, to the last bit.

        gabf.solve(net, partition=gabf.Partition(4, scheduler="tcp://127.0.0.1:8786"))
    """

    blocks: int = 2
    scheduler: str | None = None
    assignment: Ints | None = None

    def __post_init__(self) -> None:
        if not 1 <= self.blocks <= 100_000:
            raise OptionError(f"{self.blocks} blocks are not usable: give a whole number from 1 to 100000.")

    def block_of_row(self, problem: Problem) -> Ints:
        """(R,) the block of each row."""
        if self.assignment is None:
            return bands(problem, self.blocks)
        given = np.asarray(self.assignment)
        n = problem.network.n_nodes
        if given.shape != (n,) or given.dtype.kind not in "iu" or given.min() < 0 or given.max() >= self.blocks:
            raise OptionError(f"the assignment must hold ({n},) whole numbers from 0 to {self.blocks - 1}.")
        return given[problem.rows].astype(np.int64)


@dataclass(frozen=True, eq=False)
class Halo:
    """One block as the others see it.

    ``members`` (r,): its rows of the problem. ``sent`` (s,): positions in ``members`` of the rows that other blocks
    read. ``received`` (h,): what it reads of others, as positions in all that is sent, block after block.
    """

    members: Ints
    sent: Ints
    received: Ints


def bands(problem: Problem, blocks: int) -> Ints:
    """(R,) consecutive bands of about equal arcs, in reverse Cuthill-McKee order of the rows."""
    if blocks == 1 or problem.n_rows == 0:
        return np.zeros(problem.n_rows, dtype=np.int64)
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    inner = problem.heads < problem.n_rows
    pairs = problem.owners[inner], problem.heads[inner]
    shape = (problem.n_rows, problem.n_rows)
    graph = csr_matrix((np.ones(pairs[0].size, dtype=np.int8), pairs), shape=shape)
    order = reverse_cuthill_mckee(graph, symmetric_mode=False)
    arcs = np.cumsum(np.diff(problem.starts, append=problem.heads.size)[order])
    block = np.empty(problem.n_rows, dtype=np.int64)
    block[order] = np.minimum((arcs - 1) * blocks // arcs[-1], blocks - 1)
    return block


@dataclass(frozen=True, eq=False)
class Cut:
    """The blocks of a problem, and the ``boundary`` (b,): all rows that are sent, block after block."""

    problem: Problem
    halos: tuple[Halo, ...]
    boundary: Ints

    @staticmethod
    def of(problem: Problem, block: Ints, blocks: int) -> Cut:
        """Cut where ``block`` (R,) says; blocks without rows are left out, all but one where no node has to move."""
        across = problem.heads < problem.n_rows
        across[across] = block[problem.owners[across]] != block[problem.heads[across]]
        is_sent = np.zeros(problem.n_rows, dtype=bool)
        is_sent[problem.heads[across]] = True
        members = [rows for k in range(blocks) if (rows := np.flatnonzero(block == k)).size]
        members = members or [np.empty(0, dtype=np.int64)]
        boundary = np.concatenate([rows[is_sent[rows]] for rows in members])
        place = np.full(problem.n_rows, -1, dtype=np.int64)
        place[boundary] = np.arange(boundary.size)
        halos = []
        for rows in members:
            arcs = _arcs_of(problem, rows)
            read = problem.heads[arcs[across[arcs]]]
            halos.append(Halo(rows, np.flatnonzero(is_sent[rows]), place[np.unique(read)]))
        return Cut(problem, tuple(halos), boundary)

    def parts(self, y: Floats) -> Iterator[tuple[Rows, Floats]]:
        """Of each block: its rows, and its states out of ``y`` (R + S,): its own, those it receives, and sources."""
        problem = self.problem
        position = np.empty(problem.nodes.size, dtype=np.int64)
        for halo in self.halos:
            others, arcs = self.boundary[halo.received], _arcs_of(problem, halo.members)
            heads = problem.heads[arcs]
            sources = np.unique(heads[heads >= problem.n_rows])
            known = np.concatenate((halo.members, others, sources))
            position[known] = np.arange(known.size)
            counts = np.diff(problem.starts, append=problem.heads.size)[halo.members]
            yield Rows(np.cumsum(counts) - counts, position[heads], problem.arcs.take(arcs)), y[known]


def _arcs_of(problem: Problem, rows: Ints) -> Ints:
    """The arcs of ``rows``, row after row."""
    counts = np.diff(problem.starts, append=problem.heads.size)[rows]
    return ranges(problem.starts[rows], counts)
