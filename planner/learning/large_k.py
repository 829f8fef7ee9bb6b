"""How large K must be for the path of eq. (wb) to be the shortest one, and what a smaller K can cost.

Along a path p eq. (wb) gives 1 - x = the product of wbar_ij = 1 - w_ij / K, so the best path is the one of least

    C_K(p) = sum over p of -ln(1 - w / K) = D(p) / K + Q(p) / (2 K^2) + ...,    D = sum w, Q = sum w^2,

a sum of positive costs: eq. (wb) is additive under -ln(1 - x). For 0 < u < 1 the series of -ln(1 - u) lies between

    u  <  -ln(1 - u)  <  u + u^2 / 2 (1 + u + u^2 + ...)  =  u + u^2 / (2 (1 - u)).

Let p* be the shortest path, D* its length, Q* the sum of its squared weights, W* its longest weight, and K above every
weight of the network. Then for every path p

    (1)  D(p) < K C_K(p),        (2)  K C_K(p*) < D* + sum over p* of w^2 / (2 (K - w)) <= D* + Q* / (2 (K - W*)).

If every other path is longer than p* by at least ``gap``, (1) and (2) give K C_K(p*) < D* + gap <= D(p) < K C_K(p) as
soon as Q* / (2 (K - W*)) <= gap, that is for K >= W* + Q* / (2 gap): :func:`sufficient_K`. And for any K the path p_K
that eq. (wb) takes has D(p_K) < K C_K(p_K) <= K C_K(p*): it is longer than p* by less than Q* / (2 (K - W*)):
:func:`excess_bound`.
"""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import OptionError


def log_cost(weights: Floats, K: float) -> float:
    """C_K(p) of a path with these weights (k,); OptionError unless K is above all of them."""
    _require_above(K, weights)
    return float(-np.log1p(-np.asarray(weights) / K).sum())


def sufficient_K(path_weights: Floats, gap: float, longest: float) -> float:
    """A K from which on the shortest path, of weights ``path_weights`` (k,), is the only path of least C_K.

    ``gap``: by how much the second-shortest path is longer; +inf where there is none. ``longest``: the largest weight
    of the network, which K has to exceed in any case. At the returned K the claim holds if it is above ``longest``,
    above it always. +inf where ``gap`` is 0: no K tells two shortest paths apart. OptionError where gap is negative.
    """
    if not gap >= 0.0:
        raise OptionError(
            f"the gap to the second-shortest path is {gap}, but no path is shorter than the shortest one."
        )
    w = np.asarray(path_weights, dtype=np.float64)
    enough = float(w.max() + (w @ w) / (2.0 * gap)) if gap > 0.0 else np.inf
    return max(enough, longest)


def excess_bound(path_weights: Floats, K: float) -> float:
    """What the path of eq. (wb) can at most be longer than the shortest one, of weights ``path_weights`` (k,)."""
    _require_above(K, path_weights)
    w = np.asarray(path_weights, dtype=np.float64)
    return float((w @ w) / (2.0 * (K - w.max())))


def K_for_excess(longest: float, share: float) -> float:
    """A K with which the path of eq. (wb) is at most ``share`` (0.001: 0.1 %) longer than the shortest one.

    Needs no more than a bound on the largest weight: Q* <= W* D*, so the excess bound is at most share D* for
    K >= W* (1 + 1 / (2 share)).
    """
    if not share > 0.0:
        raise OptionError(f"the share of the shortest length that may be lost must be positive, not {share}.")
    return longest * (1.0 + 0.5 / share)


def _require_above(K: float, weights: Floats) -> None:
    longest = float(np.max(weights))
    if not longest < K:
        raise OptionError(f"K = {K:g} is not above the longest weight, {longest:g}: eq. (wb) needs w < K.")
