"""What a run keeps of its trajectory: nothing, every k-th step, or the states at chosen times."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from planner.base.arrays import Floats, frozen, plain_numbers
from planner.base.errors import OptionError
from planner.gabf.laws import Law, control_input
from planner.gabf.problem import Problem
from planner.gabf.result import FieldHistory
from planner.gabf.solvers import State


@dataclass(frozen=True)
class EverySteps:
    """Keep the start, every ``k``-th accepted step and the end. A larger ``k`` keeps less."""

    k: int = 1

    def __post_init__(self) -> None:
        if self.k < 1:
            raise OptionError(f"k must be at least 1, not {self.k}")


@dataclass(frozen=True, eq=False)
class AtTimes:
    """Keep the states at ascending times ``t`` >= 0, also from T_p on, where the law is inert."""

    t: Floats

    def __post_init__(self) -> None:
        t = np.array(plain_numbers("times", self.t))
        if t.ndim != 1 or not np.isfinite(t).all() or (t < 0).any() or (np.diff(t) <= 0).any():
            raise OptionError("times to save must be one row of ascending finite numbers from 0 on")
        t.setflags(write=False)
        object.__setattr__(self, "t", t)


Save: TypeAlias = EverySteps | AtTimes


class Recorder:
    """Collects states while a run goes on."""

    def __init__(self, save: Save | None, problem: Problem, law: Law):
        self.targets = law.clock.tau(save.t) if isinstance(save, AtTimes) else np.empty(0)  # to land on
        self._save, self._problem, self._law = save, problem, law
        self._kept: list[tuple[float, State]] = []
        self._landed = 0

    @property
    def keeps(self) -> bool:
        """Whether anything is to be kept."""
        return self._save is not None

    def offer(self, step: int, state: State) -> None:
        """Keep the state after ``step`` steps, if that is wanted."""
        if self._landed < self.targets.size and state.tau >= self.targets[self._landed]:
            self._kept.append((float(self.targets[self._landed]), state))
            self._landed += 1
        elif isinstance(self._save, EverySteps) and step % self._save.k == 0:
            self._kept.append((state.tau, state))

    def history(self, last: State, settled: bool) -> FieldHistory | None:
        """All that was kept. Chosen times after the end find a settled run at rest; a cut one has no answer."""
        if self._save is None:
            return None
        rest = replace(last, standing=last.standing._replace(xhat=np.zeros_like(last.standing.xhat)))
        late = [(float(tau), rest) for tau in self.targets[self._landed :] if settled]
        if isinstance(self._save, EverySteps) and self._kept[-1][1] is not last:
            late = [(last.tau, last)]
        kept = self._kept + late
        tau = np.array([reading for reading, _ in kept])
        t = self._save.t[: tau.size] if isinstance(self._save, AtTimes) else self._law.clock.time(tau)
        shape = (tau.size, self._problem.network.n_nodes)
        x = np.array([self._problem.unpack(state.y) for _, state in kept]).reshape(shape)
        inputs = (control_input(self._law, reading, _resolved(state)) for reading, state in kept)
        u = np.array([self._problem.unpack(rows, missing=0.0) for rows in inputs]).reshape(shape)
        return FieldHistory(frozen(tau), frozen(t), frozen(x), frozen(u))


def _resolved(state: State) -> Floats:
    """xhat (R,), 0 where it may be rounding, which a late gain would enlarge without end."""
    xhat = state.standing.xhat
    return np.where(np.abs(xhat) > state.resolution, xhat, 0.0)
