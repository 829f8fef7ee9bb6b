"""The contract of a solver: states of dy/dtau = -phi(y - m(y)), one after each accepted step."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from planner.base.arrays import Floats
from planner.gabf.flows import Flow
from planner.gabf.problem import Problem, Standing

ROUNDED = 64 * float(np.finfo(float).eps)
"""Share of the largest state below which a disequilibrium may be rounding: steps are not measured by less."""


@dataclass(frozen=True, eq=False)
class State:
    """The states at clock reading ``tau``, and how the rows stand there.

    ``evaluations`` counts how often the parent values were computed so far, ``rejected`` the steps that were tried in
    vain. Arrays are not to be written to, and are not changed after they were handed out.
    """

    tau: float
    standing: Standing
    evaluations: int
    rejected: int = 0

    @property
    def y(self) -> Floats:
        """(R + S,) the states."""
        return self.standing.y

    @property
    def residual(self) -> float:
        """max |xhat_i|, the Bellman residual."""
        return self.standing.residual

    @property
    def resolution(self) -> float:
        """The least |xhat| that says anything: what steps leave is rounded. The start is exact."""
        return ROUNDED * self.standing.largest if self.tau > 0.0 else 0.0


class Solver(ABC):
    """Integrates the autonomous equation in tau.

    ``order`` is the order of accuracy in the step that tests measure; ``exact_rest`` is True where a settled
    state is reached to the last bit.
    """

    name: ClassVar[str]
    order: ClassVar[int]
    exact_rest: ClassVar[bool]

    @abstractmethod
    def states(self, problem: Problem, flow: Flow, y0: Floats, targets: Floats) -> Iterator[State]:
        """The start, then a state a step, landing on every one of the ascending ``targets``, without end."""


class Targets:
    """Steps cut short so that they land on given readings of the clock."""

    def __init__(self, targets: Floats):
        self._left = [float(t) for t in targets[::-1]]

    def clip(self, tau: float, dtau: float) -> tuple[float, float]:
        """The step to take from ``tau`` and the reading it leads to; near misses are stretched."""
        while self._left and self._left[-1] <= tau:
            self._left.pop()
        if self._left and tau + 1.0001 * dtau >= self._left[-1]:
            return self._left[-1] - tau, self._left[-1]
        return dtau, tau + dtau
