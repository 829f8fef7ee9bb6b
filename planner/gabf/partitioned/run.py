"""The splitting solver on blocks: what they exchange, and the few numbers that all of them share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.base.cluster import cluster
from planner.gabf.flows import Flow
from planner.gabf.partitioned.block import Block
from planner.gabf.partitioned.cut import Cut, Partition
from planner.gabf.problem import Problem, Standing
from planner.gabf.solvers import State
from planner.gabf.splitting import Field


@dataclass(frozen=True)
class Exchanged:
    """What a run on blocks exchanged: states of other blocks' rows in all, and how often all blocks were called."""

    blocks: int
    boundary: int
    states: int
    calls: int


class PartitionedField(Field):
    """The states on blocks.

    ``blocks``: each a :class:`Block`, or a Dask actor of one. Two exchanges a step: the states that parent values are
    taken from, half a step on, and those at its end.
    ``clear_above``: residuals after which earlier states are never asked for again.
    """

    def __init__(self, cut: Cut, blocks: Sequence[Any], clear_above: float) -> None:
        self._cut, self._blocks, self._clear_above = cut, blocks, clear_above
        self._steps = self._states = self._calls = 0
        self._sent: list[Floats] = []
        self._reports: list[Standing] = self._call("report")

    @property
    def exchanged(self) -> Exchanged:
        return Exchanged(len(self._cut.halos), self._cut.boundary.size, self._states, self._calls)

    def state(self, tau: float, evaluations: int, rejected: int = 0) -> State:
        return GatheredState(self, self._steps, self._reports, tau, evaluations, rejected)

    def attempt(self, dtau: float, size: float) -> float:
        forget = max(report.residual for report in self._reports) > self._clear_above
        sent = self._call("sketch", (dtau, size, forget))
        answers = self._call("advance", (dtau, size), self._exchange(sent))
        self._sent = [sent for _, sent in answers]
        return max(share for share, _ in answers)

    def accept(self) -> None:
        self._reports = self._call("accept", (), self._exchange(self._sent))
        self._steps += 1

    def retire(self) -> None:
        self._call("retire", (min(report.lowest_moving for report in self._reports),))

    def gathered(self, step: int) -> Floats:
        """(R + S,) all states after ``step`` steps."""
        problem = self._cut.problem
        y = np.empty(problem.nodes.size)
        for halo, states in zip(self._cut.halos, self._call("states", (step,)), strict=True):
            y[halo.members] = states
        y[problem.n_rows :] = problem.anchors
        return y

    def _exchange(self, sent: Sequence[Floats]) -> list[Floats]:
        shared = np.concatenate(sent)
        halos = [shared[halo.received] for halo in self._cut.halos]
        self._states += sum(halo.size for halo in halos)
        return halos

    def _call(self, method: str, common: tuple = (), halos: Sequence[Floats] | None = None) -> list[Any]:
        self._calls += 1
        own = [()] * len(self._cut.halos) if halos is None else [(halo,) for halo in halos]
        answers = [getattr(block, method)(*common, *each) for block, each in zip(self._blocks, own, strict=True)]
        return [a if isinstance(block, Block) else a.result() for block, a in zip(self._blocks, answers, strict=True)]


class GatheredState(State):
    """A state whose residual and range the blocks report, and whose ``y`` is asked of them only if it is needed.

    Nobody asks for its xhat: on blocks no trajectory is kept.
    """

    def __init__(
        self,
        field: PartitionedField,
        step: int,
        reports: list[Standing],
        tau: float,
        evaluations: int,
        rejected: int,
    ) -> None:
        residual, lowest, highest, moving = zip(*(report[2:] for report in reports), strict=True)
        standing = reports[0]._replace(
            residual=max(residual), lowest=min(lowest), highest=max(highest), lowest_moving=min(moving)
        )
        super().__init__(tau, standing, evaluations, rejected)
        self.__dict__.update(_field=field, _step=step)  # as a frozen dataclass allows no assignment

    @cached_property
    def y(self) -> Floats:  # type: ignore[override]
        """(R + S,) the states."""
        return self.__dict__["_field"].gathered(self.__dict__["_step"])


@contextmanager
def partitioned_field(
    problem: Problem, flow: Flow, y0: Floats, partition: Partition, clear_above: float
) -> Iterator[PartitionedField]:
    """The field of a problem cut up; its blocks are gone afterwards."""
    cut = Cut.of(problem, partition.block_of_row(problem), partition.blocks)
    parts = zip(cut.halos, cut.parts(y0), strict=True)
    arguments = ((rows, y, halo.sent, halo.received.size, flow) for halo, (rows, y) in parts)
    if partition.scheduler is None:
        yield PartitionedField(cut, [Block(*each) for each in arguments], clear_above)
        return
    with cluster(partition.scheduler) as workers:
        yield PartitionedField(cut, workers.actors(Block, arguments), clear_above)
