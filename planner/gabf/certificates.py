"""What the theorems promise about a run, beside what the run did: bounds, checked and measured, ready for a file."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.gabf.flows import PowerFlow
from planner.gabf.laws import FixedTime, Law, PrescribedClock, SingularityFree, UserLaw
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
    if own := isinstance(law, UserLaw):
        settling = iter(())
    else:
        settling = _fixed_time(law, facts) if isinstance(law, FixedTime | SingularityFree) else _exponential(facts)
    made = [certificate for certificate in (*_range(facts), *settling) if certificate.applies]
    sampled = own or result.premises.sampled
    return [replace(certificate, proven=False) for certificate in made] if sampled else made


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
    rise = T_f(flow, float(optimum.values[-1]), facts.lowest, facts.result.premises.zeta)
    theorem = "theorem (singularity)" if law.prescribed_time else "theorem (fix)"
    for name, T_star, proven in (
        ("T_* as printed, which is no bound", T_star_printed(law), False),
        ("T_* corrected", T_star_corrected(law), True),
        ("T_* sharp", T_star_sharp(law), True),
    ):
        bound = settling_bound(facts.n_rows, T_star, rise)
        label = "eqs. (fixtime), (Tf)"
        yield _settling(facts, f"{theorem}, {name}", label, bound, facts.base, proven=proven)
    sharp = T_star_sharp(law)
    by_levels = settling_bound(optimum.R, sharp, rise)
    yield _settling(facts, "R levels instead of |V\\S|", "definition (S)", by_levels, facts.base, ours=True)
    rungs = np.concatenate(([facts.lowest], optimum.values[1:])) if facts.below else None
    both = two_sided_bound(flow, sharp, facts.fewest[0], rungs, facts.result.premises.zeta)
    yield _settling(facts, "from above by hops, from below by levels", "", both, facts.base, ours=True)


def _exponential(facts: Facts) -> Iterator[Certificate]:
    D, L, tolerance = facts.optimum.diameter, facts.result.premises.L, facts.result.settle_tolerance
    log_M = log_exponential_factor(facts.e_max, L, D)
    label = "eq. (boundt)" if facts.law.prescribed_time else "eq. (exTraj)"
    loose = tau_when(lambda tau: log_boundt(log_M, tau), tolerance)
    yield _settling(facts, "exponential bound", label, loose, facts.over)
    most = D - 1, tolerance
    for (hops, left), name, ours in ((most, "error bound", False), (facts.fewest, "fewest optimal hops", True)):

        def log_bound(tau: float, hops: int = hops) -> float:
            return log_errorbound(facts.e_max, L, hops, tau)

        tight = tau_when(log_bound, left, hump=hops if L > 1.0 else 0.0)
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
        lower, upper = input_bounds(clock, log_M, facts.result.premises.L, facts.error, tau)
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


def log_alpha(diameter: int) -> float:
    """ln alpha of theorem (exponential): max over k = 0 .. D - 2 of k ln(2k / e): at one of the ends."""
    k = diameter - 2
    return max(0.0, k * math.log(2.0 * k / math.e)) if k >= 1 else 0.0


def log_exponential_factor(e_max: float, L: float, diameter: int) -> float:
    """ln M, M = e_max(0) Lbar (D - 1) alpha of eqs. (exTraj) and (boundt), Lbar = max(1, L^(D - 2))."""
    if diameter < 2 or e_max <= 0:
        return -math.inf
    log_Lbar = max(0.0, (diameter - 2) * math.log(L))
    return math.log(e_max) + log_Lbar + math.log(diameter - 1) + log_alpha(diameter)


def log_boundt(log_M: float, tau: float) -> float:
    """ln of M e^(-tau / 2): eq. (exTraj) with tau = eta t, eq. (boundt) with eq. (ts)'s tau."""
    return log_M - 0.5 * tau


def log_errorbound(e_max: float, L: float, hops: int, tau: float) -> float:
    """ln of e_max(0) e^-tau sum_(k < hops) (L tau)^k / k!, eq. (errorbound), where hops is D - 1.

    Sharp: equality on a path of ``hops`` arcs whose starts all lie e_max above x*.
    """
    if hops < 1 or e_max <= 0:
        return -math.inf
    k = np.arange(hops)
    log_factorial = np.concatenate(([0.0], np.cumsum(np.log(np.arange(1, hops)))))
    power = k * math.log(L * tau) if tau > 0 else np.where(k == 0, 0.0, -np.inf)
    terms = power - log_factorial
    top = float(terms.max())
    return math.log(e_max) - tau + top + math.log(float(np.exp(terms - top).sum()))


def tau_when(log_bound: Callable[[float], float], tolerance: float, hump: float = 0.0) -> float:
    """The tau from which a bound stays below ``tolerance``, by bisection; it falls from ``hump`` on at the latest.

    Before, it may rise once: a kernel of slope above 1 enlarges errors that are within the tolerance at first.
    """
    goal = math.log(tolerance)
    low = _top(log_bound, hump)
    if log_bound(low) <= goal:
        return 0.0
    high = max(1.0, 2.0 * low)
    while log_bound(high) > goal:
        low, high = high, 2.0 * high
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if log_bound(middle) > goal else (low, middle)
    return high


def _top(log_bound: Callable[[float], float], end: float) -> float:
    """Where in [0, end] a bound of one hump is largest, in thirds."""
    low, high = 0.0, end
    for _ in range(100 if end else 0):
        third = (high - low) / 3.0
        low, high = (low + third, high) if log_bound(low + third) < log_bound(high - third) else (low, high - third)
    return low


def input_bounds(clock: PrescribedClock, log_M: float, L: float, e_start: Floats, tau: Floats) -> tuple[Floats, Floats]:
    """Lower and upper bound (k, n) on dx_i/dt at readings ``tau`` (k,): eqs. (lowerli) and (ute).

    Both go to 0 at T_p. Eq. (lowerli) is -etabar M e^(-tau / 2). Eq. (ute) is
    etabar (L M e^(-tau / 2) - e_i(0) e^-tau), since rho^-2 e^(-gamma t) = e^-tau (the lambda printed there is gamma).
    Infinite where M overflows.
    """
    tau = np.asarray(tau, dtype=np.float64)[:, None]
    log_gain = clock.log_gain(tau)
    with np.errstate(over="ignore"):
        pull = np.exp(log_gain + log_M - 0.5 * tau)
        floor = np.exp(log_gain - tau) * e_start
    return np.broadcast_to(-pull, floor.shape), L * pull - floor


def T_star_printed(law: FixedTime | SingularityFree) -> float:
    """T_* as eq. (fixtime) prints it, in tau: m2/(beta1 (m1 - m2)) + p1/(beta2 (p2 - p1)).

    Not a bound: beta1 and beta2 are swapped, and p1 stands where p2 belongs. See :func:`T_star_corrected`.
    """
    (p1, p2), (m1, m2) = law.p, law.m
    return m2 / (law.beta1 * (m1 - m2)) + p1 / (law.beta2 * (p2 - p1))


def T_star_corrected(law: FixedTime | SingularityFree) -> float:
    """The bound that eq. (fixtime) means, in tau: m2/(beta2 (m1 - m2)) + p2/(beta1 (p2 - p1)).

    From infinity to 1 the power above one alone takes the first term, from 1 to 0 the power below one the
    second.
    """
    (p1, p2), (m1, m2) = law.p, law.m
    return m2 / (law.beta2 * (m1 - m2)) + p2 / (law.beta1 * (p2 - p1))


def T_star_sharp(law: FixedTime | SingularityFree) -> float:
    """The supremum itself, in tau: the time of s' = -(beta1 s^p + beta2 s^q) from infinity to 0.

    See :attr:`planner.gabf.flows.PowerFlow.total_time`.
    """
    return law.flow.total_time


def T_f(flow: PowerFlow, highest: float, lowest: float, zeta: float) -> float:
    """Right side of eq. (Tf), in tau: (xbar_R* - zeta - min{xbar_1*, x_min(0)}) / phi(zeta).

    It may be negative, and infinite where no double holds phi(zeta) to its digits.
    """
    return _at_pace(highest - zeta - lowest, flow.speed(zeta))


def _at_pace(distance: float, speed: float) -> float:
    if speed < np.finfo(float).tiny:
        return math.copysign(math.inf, distance) if distance else 0.0
    return distance / speed


def settling_bound(levels: int, T_star: float, rise: float) -> float:
    """2 levels T_* + levels max(0, T_f): theorem (fix) with levels = |V \\ S|, or R of definition (S)."""
    return 2.0 * levels * T_star + levels * max(0.0, rise)


def two_sided_bound(flow: PowerFlow, T_star: float, hops: int, rungs: Floats | None, zeta: float) -> float:
    """Ours: the time after which x <= x* and the time after which x >= x*, whichever is longer.

    From above: x_i > x_i* falls at least at phi(e_i) once one true parent has e <= 0, so each of at most
    ``hops`` arcs of an optimal path of fewest hops costs one T_*. From below: the first half of lemma
    (overfinite) needs only x_j >= x_j* on the levels before, and lifts the least state of the others from one
    of ``rungs`` (lowest start, xbar_1*, .., xbar_R*) to the next at phi(zeta) until zeta is missing, then by
    the law's own decay. ``rungs`` is None where no start lies below x*.
    """
    above = hops * T_star
    if rungs is None:
        return above
    gaps = np.diff(rungs)
    rise = _at_pace(float(np.maximum(gaps - zeta, 0.0).sum()), flow.speed(zeta))
    last = sum(flow.time_between(float(gap), 0.0) for gap in np.minimum(gaps, zeta) if gap > 0)
    return max(above, rise + last)
