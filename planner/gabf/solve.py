"""Run a law on a network until its cost-to-go is proved settled."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.errors import AssumptionError, OptionError
from planner.gabf.flows import Flow
from planner.gabf.laws import Law, control_input, law_of
from planner.gabf.network import Network
from planner.gabf.oracle import oracle
from planner.gabf.problem import Premises, Problem, pack_start, premises, reduce, require_overestimate
from planner.gabf.result import CostToGo, Ending, FieldHistory
from planner.gabf.splitting import Splitting, State, run


def solve(
    net: Network,
    law: Law | str | None = None,
    x0: Floats | float | None = None,
    solver: Splitting | None = None,
    *,
    save_every: int = 0,
    settle_tolerance: float = 1e-9,
    max_steps: int = 300_000,
    until_tau: float = np.inf,
) -> CostToGo:
    """The cost-to-go x of every node under ``law``, from the start ``x0``.

    ``law``: a law, or the name of one with the paper's parameters, "nominal", "prescribed-time", "fixed-time" or
    "singularity-free"; the last one where left out.
    ``x0``: (n,) states, one number for all, or None for :func:`overestimate`, from which every law settles.
    Starting from an earlier ``result.x`` after weights changed is how GABF heals; nodes that were unreachable
    (+inf) then need a number. Values at sources and at nodes that reach no source are ignored. ``solver``:
    how finely it steps. ``save_every``: the start, every so manieth state and the end become ``history``; 0 keeps none.
    ``settle_tolerance`` defines settled, relative to max(1, |x_i*|); a larger one settles earlier and changes
    neither x nor the steps: a run ends at a residual of exactly 0. When it settled is dated by the run's steps, within
    ``result.settling_tau_bracket``, which is proved. ``max_steps``, rejected ones too, and ``until_tau`` bound the
    work; a run is at ``until_tau`` exactly where it ends there.

    Raises AssumptionError, naming node and arc, where the kernel is not increasing and progressive on the
    interval that the run stays in, where a start lies outside the kernel's domain, and where the
    prescribed-time law does not start above x*.

    >>> network = gabf.Network.from_arcs([1, 2, 2], [0, 0, 1], [1.0, 5.0, 1.0], sources=[0], n_nodes=3)
    >>> result = gabf.solve(network, law=gabf.SingularityFree(T=2.0))
    >>> result.x, result.outcome.key, bool(result.settling_time < 2.0)
    (array([0., 1., 2.]), 'settled', True)
    """
    if not (settle_tolerance > 0 and until_tau >= 0 and max_steps >= 0 and save_every >= 0):
        raise OptionError("settle_tolerance must be positive, max_steps, until_tau and save_every not negative.")
    law, problem = law_of(law), reduce(net)
    y0 = pack_start(problem, x0)
    bounds = premises(problem, y0)
    if law.needs_overestimate and x0 is not None:
        require_overestimate(problem, y0, problem.pack(oracle(net)), law.name)
    course, states = Course(bounds, settle_tolerance), run(problem, law.flow, y0, solver or Splitting(), until_tau)
    step, state, kept = _run(states, course, save_every, max_steps, until_tau)
    settled = state.residual == 0.0
    if settled:
        require_rooted(problem, state.y)
    return CostToGo(
        x=frozen(problem.unpack(state.y)),
        x0=frozen(problem.unpack(y0)),
        law=law,
        problem=problem,
        premises=bounds,
        outcome=Ending.SETTLED if settled else Ending.BUDGET_SPENT,
        dated_tau=course.settling_tau(state.y, law.flow) if settled else None,
        end_tau=state.tau,
        residual=state.residual,
        lowest=course.lowest,
        highest=course.highest,
        largest_input=course.largest_input(law),
        settle_tolerance=settle_tolerance,
        steps=step,
        evaluations=1 + 2 * step + state.rejected,
        history=_history(kept if kept[-1] is state else [*kept, state], problem, law) if kept else None,
    )


def _run(
    states: Iterator[State], course: Course, save_every: int, max_steps: int, until_tau: float
) -> tuple[int, State, list[State]]:
    """How many steps a run takes until it settles or its budget is spent, its last state, and those to keep."""
    kept: list[State] = []
    for step, state in enumerate(states):
        course.add(state)
        if save_every and step % save_every == 0:
            kept.append(state)
        if state.residual == 0.0 or step + state.rejected >= max_steps or state.tau >= until_tau:
            return step, state, kept
    raise AssertionError("a run has no end of its own")


def require_rooted(problem: Problem, y: Floats) -> None:
    """Raise AssumptionError unless a residual of zero proves y = x*.

    It does if every arc visibly adds to its head's value, and also if tight arcs (y_i = f_i(y_j, w_ij)) lead from every
    node to a source. Neither may hold for starts below x* on arcs whose cost vanishes beside x in double precision.
    """
    heads = y[problem.heads]
    values = problem.arcs(heads)
    if (values > heads).all():
        return
    unrooted = np.flatnonzero(problem.hops_along(values == y[problem.owners]) < 0)
    if unrooted.size:
        i = int(unrooted[0])
        raise AssumptionError(
            f"node {problem.nodes[i]} is stuck at {y[i]:g}: an arc cost on its path vanishes beside that in "
            "double precision, so the kernel is not progressive; start from overestimate(net), or rescale"
        )


@dataclass(eq=False)
class Course:
    """The extremes of a run's states, and those since the last one that was provably not settled.

    All that the settling time depends on are the latter. If every error were within the tolerance band, the residual
    would be at most (1 + L) times the widest band; a larger one, ``clear_above``, clears their list. So it holds a
    handful of states under the laws that end in finite time.
    """

    premises: Premises
    tolerance: float
    lowest: float = math.inf
    highest: float = -math.inf
    _states: list[State] = field(default_factory=list)
    _readings: list[tuple[float, float]] = field(default_factory=list)

    @property
    def clear_above(self) -> float:
        widest = self.tolerance * max(1.0, abs(self.premises.lower), abs(self.premises.upper))
        return (1.0 + self.premises.L) * widest

    def add(self, state: State) -> None:
        """Remember the state that comes next."""
        self.lowest = min(self.lowest, state.standing.lowest)
        self.highest = max(self.highest, state.standing.highest)
        self._readings.append((state.tau, state.residual if state.residual > state.resolution else 0.0))
        if state.residual > self.clear_above:
            self._states.clear()
        self._states.append(state)

    def largest_input(self, law: Law) -> float:
        """The largest |dx_i/dt| of the states: where the residual is largest, as the gain is common to all nodes."""
        tau, residual = np.array(self._readings).T
        return float(-control_input(law, tau, residual).min(initial=0.0))

    def settling_tau(self, y_star: Floats, flow: Flow) -> float:
        """The first tau after which all errors stay in the band, placed in its step by the law's decay."""
        scale = np.maximum(1.0, np.abs(y_star))
        tau = [state.tau for state in self._states]
        error = [float((np.abs(state.y - y_star) / scale).max()) for state in self._states]
        outside = np.flatnonzero(np.array(error) > self.tolerance)
        if outside.size == 0:
            return tau[0]
        k = int(outside[-1])
        worst = float(scale[np.argmax(np.abs(self._states[k].y - y_star) / scale)])
        first, second, width = (worst * share for share in (*error[k : k + 2], self.tolerance))
        step, fall = tau[k + 1] - tau[k], flow.time_between(first, width)
        whole = flow.time_between(first, second) if second > 0.0 else step
        return tau[k] + (step * min(1.0, fall / whole) if whole > 0.0 else step)


def _history(kept: list[State], problem: Problem, law: Law) -> FieldHistory:
    tau = np.array([state.tau for state in kept])
    x = np.array([problem.unpack(state.y) for state in kept])
    inputs = (control_input(law, state.tau, _resolved(state)) for state in kept)
    u = np.array([problem.unpack(rows, missing=0.0) for rows in inputs])
    return FieldHistory(frozen(tau), frozen(law.clock.time(tau)), frozen(x), frozen(u))


def _resolved(state: State) -> Floats:
    """xhat (R,), 0 where it may be rounding, which a late gain would enlarge without end."""
    xhat = state.standing.xhat
    return np.where(np.abs(xhat) > state.resolution, xhat, 0.0)
