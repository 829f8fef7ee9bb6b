"""The lower envelope of all paths' costs over beta: every path that some beta makes optimal, one solve at a time.

A path of a network with the kernel of eq. (finew) costs (1 - beta) Omega + beta D: a line in beta. The least cost over
all paths is concave and piecewise linear, so all its corners come from its ends: solve at both, intersect the two
lines, solve there, and put the cheaper path in between; where there is none the intersection is a corner.
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
    """A path ``nodes`` (k,), start first, that is optimal at ``beta``, its Omega and D, and the field that says so.

    ``x`` (n,) is that field; ``cost_to_go`` the run of the dynamics that it comes from, if it comes from one.
    """

    beta: float
    nodes: Ints
    manipulability: float
    distance: float
    x: Floats
    cost_to_go: gabf.CostToGo | None = None

    def at(self, beta: float) -> float:
        """The path's cost at another beta."""
        return combine_costs(beta, self.manipulability, self.distance)


@dataclass(frozen=True, eq=False)
class SupportInterval:
    """A support and the betas [``beta_min``, ``beta_max``] that its path is optimal for."""

    beta_min: float
    beta_max: float
    support: Support


class EnvelopeSearch:
    """The search for all supports of a lazy network, resting between two solves.

    ``supports`` are sorted by beta, and their paths hold; the first ``settled`` gaps between them are proven to hold no
    further path. The leftmost open gap is searched first, so the settled part goes from 0 up to :attr:`reach`. Where a
    path fails it is removed, and the search starts over on what is left.
    Every field is where the dynamics of ``law`` settles, or without a law what :func:`planner.gabf.oracle` finds: the
    same to 1e-9, mostly to the bit. ``solves`` counts runs of the dynamics, ``max_error`` is their largest relative
    error against the oracle.
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
        """Search one end, or solve once in the leftmost open gap; prove the path that is found."""
        with self._clock("gabf"):
            place, found = self._next()
        if found is None:
            return
        with self._clock("path"):
            holds = self.lazy.holds(found.nodes)
        if holds:
            self.supports.insert(place, found)
        else:
            self._begin()

    def _next(self) -> tuple[int, Support | None]:
        """The next support and its place among the others; none where a gap is settled or no start reaches a goal."""
        if len(self.supports) < 2:
            found = self._end(float(len(self.supports)))
            self.is_connected = found is not None
            return len(self.supports), found
        left, right = self.supports[self.settled : self.settled + 2]
        if not _same(left, right):
            beta = crossing(left, right)
            found = self._between(beta, left, right)
            if found.at(beta) < left.at(beta) - _slack(left.at(beta)):
                return self.settled + 1, found
        self.settled += 1
        return self.settled, None

    def _end(self, beta: float) -> Support | None:
        """The path of least D among those of least Omega (``beta`` 0), or the reverse (1); None if there is no path.

        Paths of least cost consist of tight arcs, x_i = f(x_j, w_ij). The dynamics runs once for these and once more
        on them alone for the other cost. A path that is costlier by less than ``TOLERANCE`` counts as one of them.
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
        """The field of ``network``, and the run that it comes from; started from ``near`` where any start will do."""
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
    """The intervals of a settled run of supports, from the first one's beta to the last one's, without gaps.

    Equal lines are merged, and paths that are optimal at a single beta left out, both within ``TOLERANCE``.
    """
    kept: list[Support] = []
    for support in supports:
        if kept and _same(kept[-1], support):
            continue
        while len(kept) > 1 and _adds_nothing(kept[-2], kept[-1], support):
            kept.pop()
        kept.append(support)
    corners = [crossing(a, b) for a, b in itertools.pairwise(kept)]
    ends = [supports[0].beta, *corners, supports[-1].beta] if kept else []
    return [SupportInterval(a, b, support) for (a, b), support in zip(itertools.pairwise(ends), kept, strict=True)]


def front_shares(costs: Floats) -> Floats:
    """(k, 2) of each path of a front, by its Omega and D (k, 2) from beta 0 to 1: its shares of the gain and the price.

    The gain is how much less Omega is than at beta 1, the price how much more D is; at beta 0 both shares are 1.
    """
    return np.abs(costs - costs[-1]) / np.maximum(np.abs(costs[0] - costs[-1]), 1e-300)


def find_knee(shares: Sequence[tuple[float | None, float | None]]) -> int | None:
    """The path at the knee of a front, by :func:`front_shares`; None for fewer than three paths, or unknown shares.

    It is the path farthest from the chord between the ends, with both axes scaled to [0, 1]: I. Das, On characterizing
    the "knee" of the Pareto curve based on normal-boundary intersection, Structural Optimization 18, 1999.
    """
    apart = [gain - added for gain, added in shares if gain is not None and added is not None]
    return int(np.argmax(apart)) if len(apart) > 2 else None


def crossing(left: Support, right: Support) -> float:
    """The beta at which the lines of two different supports meet, between those that they are optimal at."""
    more, less = right.manipulability - left.manipulability, left.distance - right.distance
    return float(np.clip(more / (more + less), left.beta, right.beta))


def _cheapest_path(network: gabf.Network, x: Floats, starts: Ints) -> Ints:
    return gabf.extract_path(network, x, int(starts[np.argmin(x[starts])]))


def _tight(network: gabf.Network, x: Floats) -> Bools:
    """(n_arcs,) the arcs that paths of least cost consist of."""
    tails = x[network.tails]
    return network.arcs(x[network.indices]) <= tails + TOLERANCE * np.maximum(1.0, tails)


def _slack(cost: float) -> float:
    return TOLERANCE * max(1.0, cost)


def _same(a: Support, b: Support) -> bool:
    return all(
        abs(p - q) <= _slack(max(p, q)) for p, q in ((a.manipulability, b.manipulability), (a.distance, b.distance))
    )


def _adds_nothing(left: Support, middle: Support, right: Support) -> bool:
    """Whether the middle path is nowhere cheaper than both others; it can be so only where these cross."""
    beta = crossing(left, right)
    return middle.at(beta) >= left.at(beta) - _slack(left.at(beta))
