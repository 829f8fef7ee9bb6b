"""The lower envelope of all paths' costs over beta: every path that is optimal at some beta.

A path of a network with the kernel of eq. (finew) costs (1 - beta) Omega + beta D: a line in beta. The least cost over
all paths is concave and piecewise linear, so all its corners follow from its ends: solve at both, intersect the two
lines, solve there, and insert the cheaper path; without one the intersection is a corner.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner import gabf
from planner.base.arrays import Bools, Floats, Ints, combine_costs
from planner.base.progress import Stopwatch
from planner.search.network import at_beta, path_cost
from planner.search.search import LazyNetwork

TOLERANCE = 1e-12  # relative to max(1, cost): far above the rounding of a sum of costs, far below any difference


@dataclass(frozen=True, eq=False)
class Support:
    """A path ``nodes`` (k,), start first, that is optimal at ``beta``, with its Omega, D and field.

    ``x`` (n,) is the field; ``cost_to_go`` its run of the dynamics, if any.
    """

    beta: float
    nodes: Ints
    manipulability: float
    distance: float
    x: Floats
    cost_to_go: gabf.CostToGo | None = None

    def at(self, beta: float) -> float:
        """Return the path's cost at another beta."""
        return combine_costs(beta, self.manipulability, self.distance)


@dataclass(frozen=True, eq=False)
class SupportInterval:
    """A support and the betas [``beta_min``, ``beta_max``] at which its path is optimal."""

    beta_min: float
    beta_max: float
    support: Support


class EnvelopeSearch:
    """The search for all supports of a lazy network, one solve per step.

    ``supports`` are sorted by beta, and their paths are proven; the first ``settled`` gaps between them are proven to
    have no further path. The leftmost open gap is searched first, so the settled interval extends from 0 to
    :attr:`reach`. A path that fails is removed, and the search starts again on the rest. Every field is that of the
    dynamics of ``law``, or without a law that of :func:`planner.gabf.oracle`: the same to 1e-9, mostly to the bit.
    ``solves`` counts runs of the dynamics, ``max_error`` is their largest relative error against the oracle.
    """

    def __init__(self, lazy: LazyNetwork, law: gabf.Law | None = None, clock: Stopwatch | None = None) -> None:
        self.lazy, self.law, self._clock = lazy, law, clock or Stopwatch()
        self._begin()

    def _begin(self) -> None:
        self.network, self.starts = self.lazy.network, self.lazy.starts
        self.supports: list[Support] = []
        self.settled = 0
        self.is_connected = True
        self.solves = 0
        self.max_error = 0.0

    @property
    def is_done(self) -> bool:
        """Whether every gap is settled, or no start reaches a goal."""
        return not self.is_connected or self.settled == len(self.supports) - 1 > 0

    @property
    def reach(self) -> float:
        """The beta up to which everything is proven."""
        return self.supports[self.settled].beta if self.supports else float(not self.is_connected)

    def step(self) -> None:
        """Search one end, or solve once in the leftmost open gap; prove the new path."""
        with self._clock("gabf"):
            index, support = self._next()
        if support is None:
            return
        with self._clock("path"):
            is_proven = self.lazy.prove_path(support.nodes)
        if is_proven:
            self.supports.insert(index, support)
        else:
            self._begin()

    def _next(self) -> tuple[int, Support | None]:
        """Return the next support and its index, or None where a gap is settled or no start reaches a goal."""
        if len(self.supports) < 2:
            support = self._end(float(len(self.supports)))
            self.is_connected = support is not None
            return len(self.supports), support
        left, right = self.supports[self.settled : self.settled + 2]
        if not _is_same(left, right):
            beta = crossing(left, right)
            support = self._between(beta, left, right)
            if support.at(beta) < left.at(beta) - _slack(left.at(beta)):
                return self.settled + 1, support
        self.settled += 1
        return self.settled, None

    def _end(self, beta: float) -> Support | None:
        """Return the path of least D among those of least Omega (``beta`` 0), or the reverse (1); or None.

        Paths of least cost consist of tight arcs, x_i = f(x_j, w_ij). The dynamics runs once for these and again on
        them alone for the other cost. A path that is costlier by less than ``TOLERANCE`` counts as one of them.
        """
        network = at_beta(self.network, beta)
        x, field = self._solve(network, None)
        least = float(x[self.starts].min())
        if not np.isfinite(least):
            return None
        tight = at_beta(network.without_arcs(np.flatnonzero(~_tight(network, x))), 1.0 - beta)
        equal = self.starts[x[self.starts] <= least + _slack(least)]
        nodes = _cheapest_path(tight, self._solve(tight, None)[0], equal)
        return self._support(network, nodes, x, field)

    def _between(self, beta: float, left: Support, right: Support) -> Support:
        near, network = left if beta - left.beta < right.beta - beta else right, at_beta(self.network, beta)
        x, field = self._solve(network, near.x)
        return self._support(network, _cheapest_path(network, x, self.starts), x, field)

    def _solve(self, network: gabf.Network, near: Floats | None) -> tuple[Floats, gabf.CostToGo | None]:
        """Return the field of ``network`` and its run, started from ``near`` if the law allows any start."""
        exact = gabf.oracle(network)
        if self.law is None:
            return exact, None
        field = gabf.solve(network, law=self.law, x0=None if self.law.needs_overestimate else near)
        self.solves += 1
        self.max_error = max(self.max_error, gabf.max_error(field, exact))
        return field.x, field

    def _support(self, network: gabf.Network, nodes: Ints, x: Floats, field: gabf.CostToGo | None) -> Support:
        cost = path_cost(network, nodes)
        return Support(cost.beta, nodes, cost.manipulability, cost.distance, x, field)


def support_intervals(supports: Sequence[Support]) -> list[SupportInterval]:
    """Return the intervals of settled supports, from the first one's beta to the last one's, without gaps.

    Equal lines are merged, and paths that are optimal at a single beta left out, both within ``TOLERANCE``.
    """
    lines: list[Support] = []
    for support in supports:
        if lines and _is_same(lines[-1], support):
            continue
        while len(lines) > 1 and _is_redundant(lines[-2], lines[-1], support):
            lines.pop()
        lines.append(support)
    corners = [crossing(a, b) for a, b in itertools.pairwise(lines)]
    ends = [supports[0].beta, *corners, supports[-1].beta] if lines else []
    return [SupportInterval(a, b, support) for (a, b), support in zip(itertools.pairwise(ends), lines, strict=True)]


def front_shares(costs: Floats) -> Floats:
    """Return (k, 2) shares of the gain and of the price, from Omega and D (k, 2) of a front by beta.

    The gain is the saving of Omega over beta 1, the price the additional D; at beta 0 both shares are 1.
    """
    return np.abs(costs - costs[-1]) / np.maximum(np.abs(costs[0] - costs[-1]), 1e-300)


def find_knee(shares: Sequence[tuple[float | None, float | None]]) -> int | None:
    """Return the index of the path at the knee of a front, by :func:`front_shares`; None for under three.

    It is the path farthest from the chord between the ends, with both axes scaled to [0, 1]: I. Das, On characterizing
    the "knee" of the Pareto curve based on normal-boundary intersection, Structural Optimization 18, 1999. None for
    unknown shares too.
    """
    apart = [gain - added for gain, added in shares if gain is not None and added is not None]
    return int(np.argmax(apart)) if len(apart) > 2 else None


def crossing(left: Support, right: Support) -> float:
    """Return the beta at which the lines of two different supports meet, between their own betas."""
    more, less = right.manipulability - left.manipulability, left.distance - right.distance
    return float(np.clip(more / (more + less), left.beta, right.beta))


def _cheapest_path(network: gabf.Network, x: Floats, starts: Ints) -> Ints:
    return gabf.extract_path(network, x, int(starts[np.argmin(x[starts])]))


def _tight(network: gabf.Network, x: Floats) -> Bools:
    """Return (n_arcs,) which arcs paths of least cost consist of."""
    tails = x[network.tails]
    return network.arcs(x[network.indices]) <= tails + TOLERANCE * np.maximum(1.0, tails)


def _slack(cost: float) -> float:
    return TOLERANCE * max(1.0, cost)


def _is_same(a: Support, b: Support) -> bool:
    return all(
        abs(p - q) <= _slack(max(p, q)) for p, q in ((a.manipulability, b.manipulability), (a.distance, b.distance))
    )


def _is_redundant(left: Support, middle: Support, right: Support) -> bool:
    """Return whether the middle path is nowhere cheaper than both others: not where these cross."""
    beta = crossing(left, right)
    return middle.at(beta) >= left.at(beta) - _slack(left.at(beta))
