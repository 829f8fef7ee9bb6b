"""What the theorems promise about a run, beside what the run did: checked, measured, and ready for a file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.gabf import bounds
from planner.gabf.laws import FixedTime, Law, PrescribedClock, SingularityFree
from planner.gabf.network import Network
from planner.gabf.oracle import TIES, Structure, oracle, structure
from planner.gabf.problem import reduce
from planner.gabf.result import CostToGo, FieldHistory

_NARROWER = (0.1, 0.01)
"""Widths of the brackets of a settling tau that a bound is compared with, after the default one."""


@dataclass(frozen=True)
class Assumption:
    """One assumption of a theorem, whether the data meet it, and by what number."""

    name: str
    holds: bool
    value: str


@dataclass(frozen=True)
class Certificate:
    """A bound of the paper, or one of ``ours``, beside the measured value; ``slack`` >= 0 where it holds.

    A settling tau is proved to lie between ``earliest`` and ``latest``, and ``measured`` is the one of these that is
    nearest to what the run's steps say. While the bound lies between the earliest and that, both are narrowed; where
    they are 1 % apart and it still does, the law settles at the bound as far as is known: that is ``measured`` then.

    ``quantity`` says what both numbers are. A theorem whose ``assumptions`` fail promises nothing.
    ``proven`` is False for what the paper prints and we refute, kept for comparison, and for every bound where L and
    zeta are only sampled, of a :class:`planner.gabf.kernels.UserKernel`.
    ``log10_remaining`` is log10(T_p - t) at a bound in tau: how long before T_p the law is promised to have
    settled.
    """

    name: str
    equation: str
    quantity: str
    bound: float
    measured: float | None
    slack: float | None = field(init=False)
    assumptions: tuple[Assumption, ...]
    ours: bool = False
    log10_remaining: float | None = None
    proven: bool = True
    earliest: float | None = None
    latest: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "slack", None if self.measured is None else self.bound - self.measured)

    @property
    def applies(self) -> bool:
        return all(assumption.holds for assumption in self.assumptions)

    @property
    def holds(self) -> bool:
        """Slack of at least 0, up to rounding of the two numbers it is the difference of."""
        if self.slack is None or self.measured is None:
            return False
        return self.slack >= -1e-12 * max(1.0, abs(self.measured))

    def to_dict(self) -> dict[str, Any]:
        """For JSON: numbers that overflow become null."""
        plain = asdict(self) | {"applies": self.applies, "holds": self.holds}
        return {key: None if _is_infinite(value) else value for key, value in plain.items()}


@dataclass(frozen=True, eq=False)
class Facts:
    """The symbols that the bounds are made of, read off one run and its optimum."""

    law: Law
    result: CostToGo
    optimum: Structure
    error: Floats
    base: tuple[Assumption, ...]

    @property
    def n_rows(self) -> int:
        return self.error.size

    @property
    def e_max(self) -> float:
        """Largest overestimate of the start, eq. (largestini); 0 if there is none."""
        return float(self.error.max(initial=0.0))

    @property
    def lowest(self) -> float:
        """min{xbar_1*, x_min(0)}, lemma (globalbound)."""
        rows = self.optimum.level > 0
        return float(min(self.optimum.x_star[rows].min(), self.result.x0[rows].min()))

    @property
    def below(self) -> bool:
        return bool((self.error < 0).any())

    @property
    def fewest(self) -> tuple[int, float]:
        """Arcs on a path of fewest hops, at most, and the tolerance that is left of such a path beside the optimum.

        It costs more by what counts as a tie at each of its arcs. Where that is all of the tolerance: the most hops.
        """
        hops, L, tolerance = int(self.optimum.fewest.max()), self.result.premises.L, self.result.settle_tolerance
        errors = hops if L <= 1.0 else math.expm1(min(hops * math.log(L), 700.0)) / (L - 1.0)
        left = tolerance - TIES * errors * max(1.0, float(np.abs(self.optimum.x_star[self.optimum.level >= 0]).max()))
        return (hops, left) if left > 0.0 else (self.optimum.diameter - 1, tolerance)

    @property
    def over(self) -> tuple[Assumption, ...]:
        """Assumption (over) added to the general ones."""
        least = float(self.error.min(initial=np.inf))
        strict = Assumption("(over): starts above x*", least > 0, f"least excess {least:.6g}")
        return (*self.base, strict)


def certify(net: Network, law: Law, result: CostToGo, optimum: Structure | None = None) -> list[Certificate]:
    """Every bound of the paper, and ours, whose assumptions this run meets.

    ``optimum``: from :func:`structure` unless given. Bounds on the settling time are in tau, where they stay
    representable. Bounds on the whole trajectory and on the control input need a result that saved its
    states.
    """
    if not (reachable := reduce(net)).n_rows:
        return []
    known = result.x if result.residual == 0.0 else oracle(net)
    optimum = structure(net, known) if optimum is None else optimum
    facts = _facts(law, result, optimum, reachable.rows)
    settling = _fixed_time(law, facts) if isinstance(law, FixedTime | SingularityFree) else _exponential(facts)
    made = [certificate for certificate in (*_range(facts), *settling) if certificate.applies]
    return [replace(certificate, proven=False) for certificate in made] if result.premises.sampled else made


def _facts(law: Law, result: CostToGo, optimum: Structure, rows: Any) -> Facts:
    premises = result.premises
    how = "sampled" if premises.sampled else "exact"
    left_out = optimum.unreachable.size
    visible = bool((optimum.longest[rows] > 0).all())
    lost = "" if visible else ", but an arc's cost vanishes beside x* in double precision"
    base = (
        Assumption("(main): a path to the sources", True, f"{left_out} nodes without one left out"),
        Assumption("(Lip): Lipschitz", math.isfinite(premises.L), f"L = {premises.L:.6g}, {how}"),
        Assumption("progressive", premises.zeta > 0 and visible, f"zeta = {premises.zeta:.6g}, {how}{lost}"),
    )
    error = result.x0[rows] - optimum.x_star[rows]
    return Facts(law, result, optimum, error, base)


def _settling(
    facts: Facts, name: str, equation: str, bound: float, assumptions: tuple[Assumption, ...], **kind: bool
) -> Certificate:
    measured, earliest, latest = _date(facts.result, bound)
    remaining = facts.law.clock.log10_remaining(bound) if math.isfinite(bound) else None
    more: dict[str, Any] = {"log10_remaining": remaining, "earliest": earliest, "latest": latest, **kind}
    return Certificate(name, equation, "settling tau", bound, measured, assumptions, **more)


def _date(result: CostToGo, bound: float) -> tuple[float, float, float] | tuple[None, None, None]:
    """The settling tau beside a ``bound`` on it, and between what it is proved to lie, see :class:`Certificate`."""
    date, bracket = result.settling_tau, result.settling_tau_bracket
    for width in _NARROWER:
        if date is None or bracket is None or not bracket[0] <= bound < date:
            break
        date, bracket = result.dated_within(width), result.settling_within(width)
    if date is None or bracket is None:
        return None, None, None
    return (bound if bracket[0] <= bound < date else date), *bracket


def _fixed_time(law: FixedTime | SingularityFree, facts: Facts) -> Iterator[Certificate]:
    flow, optimum = law.flow, facts.optimum
    rise = bounds.T_f(flow, float(optimum.values[-1]), facts.lowest, facts.result.premises.zeta)
    theorem = "theorem (singularity)" if law.prescribed_time else "theorem (fix)"
    for name, T_star, proven in (
        ("T_* as printed, which is no bound", bounds.T_star_printed(law), False),
        ("T_* corrected", bounds.T_star_corrected(law), True),
        ("T_* sharp", bounds.T_star_sharp(law), True),
    ):
        bound = bounds.settling_bound(facts.n_rows, T_star, rise)
        label = "eqs. (fixtime), (Tf)"
        yield _settling(facts, f"{theorem}, {name}", label, bound, facts.base, proven=proven)
    sharp = bounds.T_star_sharp(law)
    by_levels = bounds.settling_bound(optimum.R, sharp, rise)
    yield _settling(facts, "R levels instead of |V\\S|", "definition (S)", by_levels, facts.base, ours=True)
    rungs = np.concatenate(([facts.lowest], optimum.values[1:])) if facts.below else None
    both = bounds.two_sided_bound(flow, sharp, facts.fewest[0], rungs, facts.result.premises.zeta)
    yield _settling(facts, "from above by hops, from below by levels", "", both, facts.base, ours=True)


def _exponential(facts: Facts) -> Iterator[Certificate]:
    D, L, tolerance = facts.optimum.diameter, facts.result.premises.L, facts.result.settle_tolerance
    log_M = bounds.log_exponential_factor(facts.e_max, L, D)
    label = "eq. (boundt)" if facts.law.prescribed_time else "eq. (exTraj)"
    loose = bounds.tau_when(lambda tau: bounds.log_boundt(log_M, tau), tolerance)
    yield _settling(facts, "exponential bound", label, loose, facts.over)
    most = D - 1, tolerance
    for (hops, left), name, ours in ((most, "error bound", False), (facts.fewest, "fewest optimal hops", True)):

        def log_bound(tau: float, hops: int = hops) -> float:
            return bounds.log_errorbound(facts.e_max, L, hops, tau)

        tight = bounds.tau_when(log_bound, left, hump=hops if L > 1.0 else 0.0)
        yield _settling(facts, name, "eq. (errorbound)", tight, facts.over, ours=ours)
    saved = facts.result.history
    if saved is not None and saved.u.any():
        yield from _along_trajectory(facts, saved, log_M)


def _along_trajectory(facts: Facts, saved: FieldHistory, log_M: float) -> Iterator[Certificate]:
    # later states are rounding, whose distance from x* no law makes smaller
    rows, live = facts.optimum.level > 0, np.isfinite(saved.tau) & saved.u.any(axis=1)
    tau, x, u = saved.tau[live], saved.x[live][:, rows], saved.u[live][:, rows]
    error = x - facts.optimum.x_star[rows]
    with np.errstate(over="ignore"):
        limit = np.exp(log_M - 0.5 * tau)[:, None]
    yield _least_slack("x - x* along the run", "eq. (boundt)", "x - x*", limit, error, facts.over)
    yield _least_slack("x* is not undershot", "lemma (over)", "x* - x", np.zeros_like(error), -error, facts.over)
    clock = facts.law.clock
    if isinstance(clock, PrescribedClock):
        lower, upper = bounds.input_bounds(clock, log_M, facts.result.premises.L, facts.error, tau)
        yield _least_slack("control input from below", "eq. (lowerli)", "-dx/dt", -lower, -u, facts.over)
        yield _least_slack("control input from above", "eq. (ute)", "dx/dt", upper, u, facts.over)


@np.errstate(over="ignore")
def _least_slack(
    name: str, equation: str, quantity: str, bound: Floats, measured: Floats, assumptions: tuple[Assumption, ...]
) -> Certificate:
    """The state and node where the bound is closest."""
    bound = np.broadcast_to(bound, measured.shape)
    at = np.unravel_index(int(np.argmin(bound - measured)), measured.shape)
    return Certificate(name, equation, quantity, float(bound[at]), float(measured[at]), assumptions)


def _range(facts: Facts) -> list[Certificate]:
    """No state leaves the interval that the premises were checked on."""
    lowest, highest, upper = facts.result.lowest, facts.result.highest, facts.result.premises.upper
    below, above = ("no state falls below", "lemma (globalbound)"), ("no state rises above", "lemma (globalexistence)")
    return [
        Certificate(*below, "-min x", -facts.lowest, -lowest, facts.base),
        Certificate(*above, "max x", upper, highest, facts.base, ours=True),
    ]


def _is_infinite(value: Any) -> bool:
    return isinstance(value, float) and not math.isfinite(value)
