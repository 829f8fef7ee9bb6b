"""Bounds that the theorems state for a run, each with the measured value."""

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.gabf.enclosure import WIDTH
from planner.gabf.flows import PowerFlow
from planner.gabf.laws import FixedTime, Law, PrescribedClock, SingularityFree, UserLaw
from planner.gabf.network import Network
from planner.gabf.oracle import TIES, Structure, oracle, structure
from planner.gabf.problem import reduce_network
from planner.gabf.solve import CostToGo


@dataclass(frozen=True)
class Assumption:
    """An assumption of a theorem, whether the data meet it, and the number that decides."""

    name: str
    holds: bool
    value: str


@dataclass(frozen=True)
class Certificate:
    """A bound of the paper, or one of ``ours``, and the measured value; ``slack`` >= 0 where it holds.

    The settling tau is proved to lie between ``earliest`` and ``latest``; ``measured`` is the tau of this interval
    nearest to the run's estimate. While the bound lies between ``earliest`` and ``measured``, the interval is narrowed,
    down to 1 % of its end. If the bound still lies inside, the law settles at the bound as far as is known, and that is
    ``measured``.

    ``quantity`` names both numbers. A theorem whose ``assumptions`` fail states nothing. ``proven`` is False for
    printed results of the paper that we refute, for a :class:`planner.gabf.UserKernel`, whose L and zeta are only
    sampled, and for a user's law. ``log10_remaining`` is log10(T_p - t) at a bound in tau.
    """

    name: str
    equation: str
    quantity: str
    bound: float
    measured: float | None
    assumptions: tuple[Assumption, ...]
    ours: bool = False
    log10_remaining: float | None = None
    proven: bool = True
    earliest: float | None = None
    latest: float | None = None

    @property
    def slack(self) -> float | None:
        return None if self.measured is None else self.bound - self.measured

    @property
    def applies(self) -> bool:
        return all(assumption.holds for assumption in self.assumptions)

    @property
    def holds(self) -> bool:
        """Whether the slack is at least 0, up to rounding of the two numbers."""
        if self.slack is None or self.measured is None:
            return False
        return self.slack >= -1e-12 * max(1.0, abs(self.measured))

    def to_dict(self) -> dict[str, Any]:
        """Return the fields for JSON; numbers that overflow become null."""
        plain = asdict(self) | {"slack": self.slack, "applies": self.applies, "holds": self.holds}
        return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in plain.items()}


def certify(net: Network, law: Law, result: CostToGo, optimum: Structure | None = None) -> list[Certificate]:
    """Return the bounds of the paper, and ours, whose assumptions this run meets.

    ``optimum`` is that of :func:`structure` by default. Bounds on the settling time are in tau, where doubles represent
    them; a user's law has none. Bounds on the trajectory and on the control input need a result with saved states.
    """
    if not (reachable := reduce_network(net)).n_rows:
        return []
    known = result.x if result.residual == 0.0 else oracle(net)
    facts = Facts(law, result, structure(net, known) if optimum is None else optimum, reachable.rows)
    bounds = list(_bound_states(facts))
    if isinstance(law, FixedTime | SingularityFree):
        bounds += _finite_time_bounds(law, facts)
    elif not isinstance(law, UserLaw):
        bounds += _exponential_bounds(facts)
    sampled = result.premises.sampled or isinstance(law, UserLaw)
    return [replace(c, proven=c.proven and not sampled) for c in bounds if c.applies]


@dataclass(frozen=True, eq=False)
class Facts:
    """The symbols of the bounds, from one run and its optimum; ``rows`` (R,) are the nodes that move."""

    law: Law
    result: CostToGo
    optimum: Structure
    rows: Ints

    @cached_property
    def error(self) -> Floats:
        """(R,) the start minus x*."""
        return self.result.x0[self.rows] - self.optimum.x_star[self.rows]

    @property
    def e_max(self) -> float:
        """Largest overestimate of the start, eq. (largestini); 0 if there is none."""
        return float(self.error.max(initial=0.0))

    @property
    def lowest(self) -> float:
        """min{xbar_1*, x_min(0)}, lemma (globalbound)."""
        return float(min(self.optimum.x_star[self.rows].min(), self.result.x0[self.rows].min()))

    @property
    def fewest(self) -> tuple[int, float]:
        """Most arcs of a path of fewest hops, and the tolerance minus the excess cost of such a path.

        The excess is the tie tolerance at each arc. If it uses up the whole tolerance: the most hops, and the
        tolerance.
        """
        hops, L, tolerance = int(self.optimum.fewest.max()), self.result.premises.L, self.result.settle_tolerance
        errors = hops if L <= 1.0 else math.expm1(min(hops * math.log(L), 700.0)) / (L - 1.0)
        left = tolerance - TIES * errors * max(1.0, float(np.abs(self.optimum.x_star[self.optimum.level >= 0]).max()))
        return (hops, left) if left > 0.0 else (self.optimum.diameter - 1, tolerance)

    @cached_property
    def base(self) -> tuple[Assumption, ...]:
        """The general assumptions."""
        premises, optimum = self.result.premises, self.optimum
        how, visible = "sampled" if premises.sampled else "exact", bool((optimum.longest[self.rows] > 0).all())
        lost = "" if visible else ", but an arc's cost vanishes next to x* in double precision"
        return (
            Assumption("(main): a path to the sources", True, f"{optimum.unreachable.size} nodes without one left out"),
            Assumption("(Lip): Lipschitz", math.isfinite(premises.L), f"L = {premises.L:.6g}, {how}"),
            Assumption("progressive", premises.zeta > 0 and visible, f"zeta = {premises.zeta:.6g}, {how}{lost}"),
        )

    @property
    def over(self) -> tuple[Assumption, ...]:
        """The general assumptions and (over)."""
        least = float(self.error.min(initial=np.inf))
        return (*self.base, Assumption("(over): starts above x*", least > 0, f"least excess {least:.6g}"))


def _bound_states(facts: Facts) -> Iterator[Certificate]:
    """Yield the bounds on the range of all states: the interval of the premises."""
    result, base = facts.result, facts.base
    low, high, limit = -facts.lowest, result.highest, result.premises.upper
    yield Certificate("no state falls below", "lemma (globalbound)", "-min x", low, -result.lowest, base)
    yield Certificate("no state rises above", "lemma (globalexistence)", "max x", limit, high, base, ours=True)


def _compare_settling(
    facts: Facts, name: str, equation: str, bound: float, assumptions: tuple[Assumption, ...], **kind: bool
) -> Certificate:
    measured, earliest, latest = _settling_tau(facts.result, bound)
    remaining = facts.law.clock.log10_remaining(bound) if math.isfinite(bound) else None
    more: dict[str, Any] = {"log10_remaining": remaining, "earliest": earliest, "latest": latest, **kind}
    return Certificate(name, equation, "settling tau", bound, measured, assumptions, **more)


def _settling_tau(result: CostToGo, bound: float) -> tuple[float, float, float] | tuple[None, None, None]:
    """Return the settling tau to compare with ``bound``, and the interval that is proved to contain it."""
    if result.estimated_tau is None:
        return None, None, None
    for width in (WIDTH, 0.1, 0.01):
        earliest, latest = result.settling_within(width) or (0.0, math.inf)
        date = min(max(result.estimated_tau, earliest), latest)
        if not earliest <= bound < date:
            return date, earliest, latest
    return bound, earliest, latest


def _finite_time_bounds(law: FixedTime | SingularityFree, facts: Facts) -> Iterator[Certificate]:
    flow, optimum, zeta, lowest = law.flow, facts.optimum, facts.result.premises.zeta, facts.lowest
    T_f = _travel_time(
        float(optimum.values[-1]) - zeta - lowest, flow.speed(zeta)
    )  # the right side of eq. (Tf), in tau
    theorem = "theorem (singularity)" if law.prescribed_time else "theorem (fix)"
    for kind, value in T_star(law).items():
        name = f"{theorem}, T_* {'as printed, which is no bound' if kind == 'printed' else kind}"
        bound = settling_bound(facts.rows.size, value, T_f)
        yield _compare_settling(facts, name, "eqs. (fixtime), (Tf)", bound, facts.base, proven=kind != "printed")
    sharp = T_star(law)["sharp"]
    by_levels = settling_bound(optimum.R, sharp, T_f)
    yield _compare_settling(facts, "R levels instead of |V\\S|", "definition (S)", by_levels, facts.base, ours=True)
    rungs = np.concatenate(([lowest], optimum.values[1:])) if (facts.error < 0).any() else None
    both = two_sided_bound(flow, sharp, facts.fewest[0], rungs, zeta)
    yield _compare_settling(facts, "from above by hops, from below by levels", "", both, facts.base, ours=True)


def _exponential_bounds(facts: Facts) -> Iterator[Certificate]:
    D, L, tolerance = facts.optimum.diameter, facts.result.premises.L, facts.result.settle_tolerance
    log_M = log_exponential_factor(facts.e_max, L, D)
    label = "eq. (boundt)" if facts.law.prescribed_time else "eq. (exTraj)"
    loose = tau_when(lambda tau: log_M - 0.5 * tau, tolerance)
    yield _compare_settling(facts, "exponential bound", label, loose, facts.over)
    most = D - 1, tolerance
    for (hops, left), name, ours in ((most, "error bound", False), (facts.fewest, "fewest optimal hops", True)):

        def log_bound(tau: float, hops: int = hops) -> float:
            return log_errorbound(facts.e_max, L, hops, tau)

        tight = tau_when(log_bound, left, hump=hops if L > 1.0 else 0.0)
        yield _compare_settling(facts, name, "eq. (errorbound)", tight, facts.over, ours=ours)
    if facts.result.history is not None:
        yield from _trajectory_bounds(facts, log_M)


@np.errstate(over="ignore")
def _trajectory_bounds(facts: Facts, log_M: float) -> Iterator[Certificate]:
    """Yield bounds on every saved state that still moves; rounding decides the later ones."""
    saved, clock = facts.result.history, facts.law.clock
    assert saved is not None
    live = np.isfinite(saved.tau) & saved.u.any(axis=1)
    if not live.any():
        return
    tau, error, u = saved.tau[live], saved.x[live][:, facts.rows], saved.u[live][:, facts.rows]
    error = error - facts.optimum.x_star[facts.rows]

    def closest(name: str, equation: str, quantity: str, bound: Floats, measured: Floats) -> Certificate:
        bound = np.broadcast_to(bound, measured.shape)
        at = np.unravel_index(int(np.argmin(bound - measured)), measured.shape)
        return Certificate(name, equation, quantity, float(bound[at]), float(measured[at]), facts.over)

    yield closest("x - x* along the run", "eq. (boundt)", "x - x*", np.exp(log_M - 0.5 * tau)[:, None], error)
    yield closest("x* is not undershot", "lemma (over)", "x* - x", np.zeros_like(error), -error)
    if isinstance(clock, PrescribedClock):
        lower, upper = input_bounds(clock, log_M, facts.result.premises.L, facts.error, tau)
        yield closest("control input from below", "eq. (lowerli)", "-dx/dt", -lower, -u)
        yield closest("control input from above", "eq. (ute)", "dx/dt", upper, u)


def log_alpha(diameter: int) -> float:
    """Return ln alpha of theorem (exponential): max of k ln(2k / e) over k = 0 .. D - 2.

    The maximum is at one of the ends.
    """
    k = diameter - 2
    return max(0.0, k * math.log(2.0 * k / math.e)) if k >= 1 else 0.0


def log_exponential_factor(e_max: float, L: float, diameter: int) -> float:
    """Return ln M, M = e_max(0) Lbar (D - 1) alpha, Lbar = max(1, L^(D - 2)).

    Eq. (exTraj) is M e^(-tau / 2) with tau = eta t, eq. (boundt) the same with eq. (ts)'s tau.
    """
    if diameter < 2 or e_max <= 0:
        return -math.inf
    log_Lbar = max(0.0, (diameter - 2) * math.log(L))
    return math.log(e_max) + log_Lbar + math.log(diameter - 1) + log_alpha(diameter)


def log_errorbound(e_max: float, L: float, hops: int, tau: float) -> float:
    """Return ln of e_max(0) e^-tau sum_(k < hops) (L tau)^k / k!, eq. (errorbound) with hops = D - 1.

    The bound is sharp on a path of ``hops`` arcs whose starts all lie e_max above x*.
    """
    if hops < 1 or e_max <= 0:
        return -math.inf
    k = np.arange(hops)
    log_factorial = np.concatenate(([0.0], np.cumsum(np.log(np.arange(1, hops)))))
    terms = (k * math.log(L * tau) if tau > 0 else np.where(k == 0, 0.0, -np.inf)) - log_factorial
    top = float(terms.max())
    return math.log(e_max) - tau + top + math.log(float(np.exp(terms - top).sum()))


def tau_when(log_bound: Callable[[float], float], tolerance: float, hump: float = 0.0) -> float:
    """Return the tau from which a bound stays below ``tolerance``, by bisection.

    The bound falls from ``hump`` on at the latest. Before, it may rise to one maximum, found by ternary search: a
    kernel of slope above 1 enlarges errors that are within the tolerance at first.
    """
    goal, low, high = math.log(tolerance), 0.0, hump
    for _ in range(100 if hump else 0):
        third = (high - low) / 3.0
        low, high = (low + third, high) if log_bound(low + third) < log_bound(high - third) else (low, high - third)
    if log_bound(low) <= goal:
        return 0.0
    high = max(1.0, 2.0 * low)
    while log_bound(high) > goal:
        low, high = high, 2.0 * high
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if log_bound(middle) > goal else (low, middle)
    return high


def input_bounds(clock: PrescribedClock, log_M: float, L: float, e_start: Floats, tau: Floats) -> tuple[Floats, Floats]:
    """Return lower and upper bounds (k, n) on dx_i/dt at readings ``tau`` (k,), eqs. (lowerli) and (ute).

    Both go to 0 at T_p. Eq. (lowerli) is -etabar M e^(-tau / 2). Eq. (ute) is etabar (L M e^(-tau / 2) - e_i(0)
    e^-tau), since rho^-2 e^(-gamma t) = e^-tau (the lambda printed there is gamma). Infinite where M overflows.
    """
    tau = np.asarray(tau, dtype=np.float64)[:, None]
    log_gain = clock.log_gain(tau)
    with np.errstate(over="ignore"):
        pull, floor = np.exp(log_gain + log_M - 0.5 * tau), np.exp(log_gain - tau) * e_start
    return np.broadcast_to(-pull, floor.shape), L * pull - floor


def T_star(law: FixedTime | SingularityFree) -> dict[str, float]:
    """Return T_* of eq. (fixtime), in tau: as ``printed``, ``corrected``, and ``sharp``.

    Printed is m2/(beta1 (m1 - m2)) + p1/(beta2 (p2 - p1)), no bound: beta1 and beta2 are swapped, and p1 stands for p2.
    Corrected is m2/(beta2 (m1 - m2)) + p2/(beta1 (p2 - p1)): the power above one takes the first term from infinity to
    1, the power below one the second from 1 to 0. Sharp is the time of s' = -(beta1 s^p + beta2 s^q) from infinity to
    0.
    """
    (p1, p2), (m1, m2) = law.p, law.m
    printed = m2 / (law.beta1 * (m1 - m2)) + p1 / (law.beta2 * (p2 - p1))
    corrected = m2 / (law.beta2 * (m1 - m2)) + p2 / (law.beta1 * (p2 - p1))
    return {"printed": printed, "corrected": corrected, "sharp": law.flow.whole_time}


def settling_bound(levels: int, T_star: float, T_f: float) -> float:
    """Return 2 levels T_* + levels max(0, T_f), theorem (fix).

    ``levels`` is |V \\ S|, or R of definition (S).
    """
    return 2.0 * levels * T_star + levels * max(0.0, T_f)


def _travel_time(distance: float, speed: float) -> float:
    if speed < np.finfo(float).tiny:  # no double holds its digits
        return math.copysign(math.inf, distance) if distance else 0.0
    return distance / speed


def two_sided_bound(flow: PowerFlow, T_star: float, hops: int, rungs: Floats | None, zeta: float) -> float:
    """Return the tau after which x <= x* or the one after which x >= x*, whichever is later. Ours.

    From above: x_i > x_i* falls at least at phi(e_i) once one true parent has e <= 0, so each of at most ``hops`` arcs
    of an optimal path of fewest hops costs one T_*. From below: the first half of lemma (overfinite) needs only x_j >=
    x_j* on the levels before. It lifts the least state of the others from one of ``rungs`` (lowest start, xbar_1*, ..,
    xbar_R*) to the next at phi(zeta) until zeta is missing, then by the law's own decay. ``rungs`` is None where no
    start lies below x*.
    """
    above = hops * T_star
    if rungs is None:
        return above
    gaps = np.diff(rungs)
    rise = _travel_time(float(np.maximum(gaps - zeta, 0.0).sum()), flow.speed(zeta))
    last = sum(flow.time_between(float(gap), 0.0) for gap in np.minimum(gaps, zeta) if gap > 0)
    return max(above, rise + last)
