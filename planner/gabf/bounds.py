"""The paper's bounds in its symbols; in logarithms where alpha or the gain would overflow."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from planner.base.arrays import Floats
from planner.gabf.flows import PowerFlow
from planner.gabf.laws import FixedTime, PrescribedClock, SingularityFree


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
