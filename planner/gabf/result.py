"""What a run hands back: the cost-to-go, when it settled, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.gabf.enclosure import WIDTH, bracket_settling
from planner.gabf.laws import Law
from planner.gabf.network import Network
from planner.gabf.problem import Premises, Problem


class Ending(Enum):
    """How a run ended, as the sentence its user reads."""

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
    """The field x (n,), +inf at nodes that reach no source, and the record of the run that computed it.

    :attr:`settling_tau`: the first tau from which |x_i - x_i*| <= settle_tolerance max(1, |x_i*|) for all i and for
    ever; ``dated_tau`` is its date by this run's steps alone, None if it was not reached, and
    :attr:`settling_tau_bracket` encloses it by proof, whatever the steps. ``residual`` is max |x_i - min_j f_i(x_j,
    w_ij)|, 0 where x is proved to be x* to the last bit. ``lowest`` and ``highest`` are the extreme states of
    non-source nodes over all steps, ``largest_input`` the largest |dx_i/dt| there: a figure of this run, which a
    smaller tolerance of the solver converges where the gain grows before the last node settles. ``premises`` holds the
    interval that the run stayed in with zeta and L on it, ``problem`` the part of the network that reaches a source.
    """

    x: Floats
    x0: Floats
    law: Law
    problem: Problem
    premises: Premises
    outcome: Ending
    dated_tau: float | None
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
        end = "settled" if self.dated_tau is not None else "not settled"
        return f"<CostToGo: {len(self.x)} nodes, {self.law.name} law, {end} by tau = {self.end_tau:.3g}>"

    @property
    def network(self) -> Network:
        return self.problem.network

    @property
    def settling_tau(self) -> float | None:
        """The tau of :attr:`settling_tau_bracket` that is nearest to ``dated_tau``: a few times a run's work."""
        bracket = self.settling_tau_bracket
        return None if bracket is None or self.dated_tau is None else min(max(self.dated_tau, bracket[0]), bracket[1])

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
        """The earliest and the latest tau at which the law itself can settle, proved by upper and lower solutions.

        None for a run that did not settle, (0, inf) for a user's law and for a field of too many rows times hops. Else
        they are ``width`` of the latest apart, unless that took more work than :mod:`planner.gabf.enclosure` spends, or
        errors begin within the tolerance and leave it first: then the earliest is 0. Half the width takes about twice
        the work. Raises :class:`OptionError` for a width that is no share in (0, 1].
        """
        if not 0.0 < width <= 1.0:
            raise OptionError(f"width must be above 0 and at most 1, a share of the latest, got {width:g}.")
        if self.dated_tau is not None and width not in self._brackets:
            ends = self.problem.pack(self.x0), self.problem.pack(self.x)
            band, guess = self.settle_tolerance, self.dated_tau
            flow, bounds = self.law.flow, self.premises
            self._brackets[width] = bracket_settling(self.problem, flow, *ends, bounds, band, guess, width)
        return self._brackets.get(width)
