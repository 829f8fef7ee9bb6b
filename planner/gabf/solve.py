"""Run a law on a network until its cost-to-go is proved settled, and record the run."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.errors import AssumptionError, OptionError
from planner.gabf.enclosure import WIDTH, bracket_settling
from planner.gabf.flows import Flow
from planner.gabf.laws import Law, control_input, resolve_law
from planner.gabf.network import Network
from planner.gabf.oracle import oracle
from planner.gabf.problem import (
    Premises,
    Problem,
    State,
    check_premises,
    pack_start,
    reduce_network,
    require_overestimate,
)
from planner.gabf.splitting import Splitting, run


class Ending(Enum):
    """The end of a run, as a sentence for its user."""

    SETTLED = "Every node that reaches a source settled on its optimal cost-to-go."
    BUDGET_SPENT = (
        "The budget ran out before the field was proved settled: raise max_steps or until_tau, or start from "
        "gabf.overestimate(net)."
    )

    @property
    def key(self) -> str:
        return self.name.lower()


@dataclass(frozen=True, eq=False)
class FieldHistory:
    """Saved states: ``tau`` (k,), ``t`` (k,), ``x`` (k, n) and the control input ``u`` = dx/dt (k, n).

    x is +inf and u is 0 at nodes that reach no source.
    """

    tau: Floats
    t: Floats
    x: Floats
    u: Floats


@dataclass(frozen=True, eq=False)
class CostToGo:
    """The field x (n,), +inf at nodes that reach no source, and the record of its run.

    :attr:`settling_tau` is the first tau from which |x_i - x_i*| <= settle_tolerance max(1, |x_i*|) for all i and for
    ever. ``estimated_tau`` is its estimate from this run's steps, None if it was not reached;
    :attr:`settling_tau_bracket` encloses it by proof. ``residual`` is max |x_i - min_j f_i(x_j, w_ij)|, 0 where x is
    proved to be x* to the last bit. ``lowest`` and ``highest`` are the extreme states of non-source nodes over all
    steps, ``largest_input`` the largest |dx_i/dt| there: it converges as the solver's tolerance shrinks, where the gain
    grows before the last node settles. ``premises`` is the interval of the run's states with zeta and L on it,
    ``problem`` the part of the network that reaches a source.
    """

    x: Floats
    x0: Floats
    law: Law
    problem: Problem
    premises: Premises
    outcome: Ending
    estimated_tau: float | None
    end_tau: float
    residual: float
    lowest: float
    highest: float
    largest_input: float
    settle_tolerance: float
    steps: int
    history: FieldHistory | None = None
    _brackets: dict[float, tuple[float, float]] = field(default_factory=dict, repr=False)

    def __repr__(self) -> str:
        end = "settled" if self.estimated_tau is not None else "not settled"
        return f"<CostToGo: {len(self.x)} nodes, {self.law.name} law, {end} by tau = {self.end_tau:.3g}>"

    @property
    def network(self) -> Network:
        return self.problem.network

    @property
    def settling_tau(self) -> float | None:
        """The tau of :attr:`settling_tau_bracket` nearest to ``estimated_tau``: a few times a run's work."""
        bracket = self.settling_tau_bracket
        return (
            None
            if bracket is None or self.estimated_tau is None
            else min(max(self.estimated_tau, bracket[0]), bracket[1])
        )

    @property
    def settling_time(self) -> float | None:
        """:attr:`settling_tau` in t, s."""
        return None if self.settling_tau is None else float(self.law.clock.time(self.settling_tau))

    @property
    def log10_remaining(self) -> float | None:
        """log10(T_p - t) at :attr:`settling_time`; None for laws without T_p."""
        return None if self.settling_tau is None else self.law.clock.log10_remaining(self.settling_tau)

    @property
    def settling_tau_bracket(self) -> tuple[float, float] | None:
        """:meth:`settling_within` of the default width: the latest is at most twice the earliest, in general."""
        return self.settling_within()

    def settling_within(self, width: float = WIDTH) -> tuple[float, float] | None:
        """Return the earliest and latest tau at which the law can settle, by upper and lower solutions.

        None for a run that did not settle, (0, inf) for a user's law and for a field of too many rows times hops. Else
        they are ``width`` of the latest apart, unless that takes more work than :mod:`planner.gabf.enclosure` spends,
        or errors begin within the tolerance and leave it first: then the earliest is 0. Half the width takes about
        twice the work. Raises :class:`OptionError` for a width outside (0, 1].
        """
        if not 0.0 < width <= 1.0:
            raise OptionError(f"width must be above 0 and at most 1, a share of the latest, got {width:g}.")
        if self.estimated_tau is not None and width not in self._brackets:
            ends = self.problem.pack(self.x0), self.problem.pack(self.x)
            band, guess = self.settle_tolerance, self.estimated_tau
            flow, bounds = self.law.flow, self.premises
            self._brackets[width] = bracket_settling(self.problem, flow, *ends, bounds, band, guess, width)
        return self._brackets.get(width)


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
    """Return the cost-to-go x of every node under ``law``, from the start ``x0``.

    ``law``: a law, or the name of one with the paper's parameters, "nominal", "prescribed-time", "fixed-time" or
    "singularity-free", the default. ``x0``: (n,) states, one number for all, or None for :func:`overestimate`, from
    which every law settles. From an earlier ``result.x`` the field heals after weights changed; nodes that were
    unreachable (+inf) then need a number. Values at sources and at nodes that reach no source are ignored. ``solver``:
    the size of its steps. ``save_every``: the start, each state after so many steps and the end become ``history``; 0
    saves none. ``settle_tolerance`` defines settled, relative to max(1, |x_i*|); a larger one settles earlier and
    changes neither x nor the steps: a run ends at a residual of exactly 0. ``max_steps``, rejected ones too, and
    ``until_tau`` bound the work; a run is at ``until_tau`` exactly where it ends there.

    Raises AssumptionError, naming node and arc, where the kernel is not increasing and progressive on the interval of
    the run's states, where a start lies outside the kernel's domain, and where the prescribed-time law does not start
    above x*.

    >>> network = gabf.Network.from_arcs([1, 2, 2], [0, 0, 1], [1.0, 5.0, 1.0], sources=[0], n_nodes=3)
    >>> result = gabf.solve(network, law=gabf.SingularityFree(T=2.0))
    >>> result.x, result.outcome.key, bool(result.settling_time < 2.0)
    (array([0., 1., 2.]), 'settled', True)
    """
    if not (settle_tolerance > 0 and until_tau >= 0 and max_steps >= 0 and save_every >= 0):
        raise OptionError("settle_tolerance must be positive; max_steps, until_tau and save_every at least 0.")
    law, problem = resolve_law(law), reduce_network(net)
    y0 = pack_start(problem, x0)
    bounds = check_premises(problem, y0)
    if law.needs_overestimate and x0 is not None:
        require_overestimate(problem, y0, problem.pack(oracle(net)), law.name)
    monitor = SettlingMonitor(law.flow, bounds, settle_tolerance)
    states = run(problem, law.flow, y0, solver or Splitting(), until_tau)
    step, state, saved = _run(states, monitor, save_every, max_steps, until_tau)
    if settled := state.residual == 0.0:
        require_roots(problem, state.y)
    return CostToGo(
        x=frozen(problem.unpack(state.y)),
        x0=frozen(problem.unpack(y0)),
        law=law,
        problem=problem,
        premises=bounds,
        outcome=Ending.SETTLED if settled else Ending.BUDGET_SPENT,
        estimated_tau=monitor.settling_tau(state.y) if settled else None,
        end_tau=state.tau,
        residual=state.residual,
        lowest=monitor.lowest,
        highest=monitor.highest,
        largest_input=monitor.largest_input(law),
        settle_tolerance=settle_tolerance,
        steps=step,
        history=_history(saved if saved[-1] is state else [*saved, state], problem, law) if saved else None,
    )


def _run(
    states: Iterator[State], monitor: SettlingMonitor, save_every: int, max_steps: int, until_tau: float
) -> tuple[int, State, list[State]]:
    """Return the number of steps until the run settles or spends its budget, its last and saved states."""
    saved: list[State] = []
    for step, state in enumerate(states):
        monitor.add(state)
        if save_every and step % save_every == 0:
            saved.append(state)
        if state.residual == 0.0 or step + state.rejected >= max_steps or state.tau >= until_tau:
            return step, state, saved
    raise AssertionError("a run has no end of its own")


def require_roots(problem: Problem, y: Floats) -> None:
    """Raise AssumptionError unless a residual of zero proves y = x*.

    It does if every arc visibly adds to its head's value, and also if tight arcs (y_i = f_i(y_j, w_ij)) lead from every
    node to a source. Neither may hold for starts below x* on arcs whose cost vanishes next to x in double precision.
    """
    heads = y[problem.heads]
    values = problem.arcs(heads)
    if (values > heads).all():
        return
    unrooted = np.flatnonzero(problem.hops_along(values == y[problem.owners]) < 0)
    if unrooted.size:
        i = int(unrooted[0])
        raise AssumptionError(
            f"node {problem.nodes[i]} is stuck at {y[i]:g}: an arc cost on its path vanishes next to that in double "
            "precision, so the kernel is not progressive: start from overestimate(net), or rescale."
        )


@dataclass(eq=False)
class SettlingMonitor:
    """The extremes of a run's states, and the states since the last one that was provably not settled.

    The settling time depends on the latter only. If every error were within the tolerance band, the residual would be
    at most (1 + L) times the widest band; a larger one clears their list. So it contains a handful of states under the
    laws that settle in finite time.
    """

    flow: Flow
    premises: Premises
    tolerance: float
    lowest: float = math.inf
    highest: float = -math.inf
    _states: list[State] = field(default_factory=list)
    _readings: list[tuple[float, float]] = field(default_factory=list)

    def add(self, state: State) -> None:
        """Record the next state."""
        self.lowest, self.highest = min(self.lowest, state.lowest), max(self.highest, state.highest)
        worst = state.residual if state.residual > state.resolution else 0.0
        if self.flow.compiled is None and worst > 0.0:  # a user's phi may be largest elsewhere
            worst = float(state.xhat[np.argmax(np.abs(self.flow.rate(state.xhat)))])
        self._readings.append((state.tau, worst))
        widest = self.tolerance * max(1.0, abs(self.premises.lower), abs(self.premises.upper))
        if state.residual > (1.0 + self.premises.L) * widest:
            self._states.clear()
        self._states.append(state)

    def largest_input(self, law: Law) -> float:
        """Return the largest |dx_i/dt| of the states: at the largest phi, as the gain is common to all nodes."""
        return float(np.abs(control_input(law, *np.array(self._readings).T)).max(initial=0.0))

    def settling_tau(self, y_star: Floats) -> float:
        """Return the first tau after which all errors stay in the band, interpolated by the law's decay."""
        scale = np.maximum(1.0, np.abs(y_star))
        tau = [state.tau for state in self._states]
        error = [float((np.abs(state.y - y_star) / scale).max()) for state in self._states]
        outside = np.flatnonzero(np.array(error) > self.tolerance)
        if outside.size == 0:
            return tau[0]
        k = int(outside[-1])
        worst = float(scale[np.argmax(np.abs(self._states[k].y - y_star) / scale)])
        first, second, width = (worst * share for share in (*error[k : k + 2], self.tolerance))
        step, fall = tau[k + 1] - tau[k], self.flow.time_between(first, width)
        whole = self.flow.time_between(first, second) if second > 0.0 else step
        return tau[k] + (step * min(1.0, fall / whole) if whole > 0.0 else step)


def _history(saved: list[State], problem: Problem, law: Law) -> FieldHistory:
    tau = np.array([state.tau for state in saved])
    x = np.array([problem.unpack(state.y) for state in saved])
    # 0 where xhat may be rounding: a late gain would enlarge it without bound
    xhat = (np.where(np.abs(state.xhat) > state.resolution, state.xhat, 0.0) for state in saved)
    u = np.array([problem.unpack(control_input(law, *at), missing=0.0) for at in zip(tau, xhat, strict=True)])
    return FieldHistory(frozen(tau), frozen(law.clock.time(tau)), frozen(x), frozen(u))
