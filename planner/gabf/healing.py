"""Heal a field after a change: start from the current x, raised only where its support is gone.

From below, x counts up at the pace of the smallest arc cost; from above it falls in as many steps as there are hops. So
states that a change may have left too low are first raised to an overestimate; all others stay.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints, frozen
from planner.base.errors import AssumptionError, OptionError
from planner.gabf.laws import Law, resolve_law
from planner.gabf.network import Network
from planner.gabf.oracle import max_error, oracle
from planner.gabf.problem import check_states, reduce_network
from planner.gabf.solve import CostToGo, solve


@dataclass(frozen=True, eq=False)
class Healing:
    """A field that settled again; ``raised`` (k,) nodes were lifted first, ``moved`` (m,) changed.

    The run's own clock begins at 0; ``since_tau`` is the reading of an earlier clock when the network changed.
    """

    cost_to_go: CostToGo
    raised: Ints
    moved: Ints
    since_tau: float

    @property
    def settling_tau(self) -> float | None:
        """The settling tau on the clock that ran when the network changed."""
        tau = self.cost_to_go.settling_tau
        return None if tau is None else self.since_tau + tau

    @property
    def settling_time(self) -> float | None:
        """The settling time in seconds: before T_p under a law that has one, as every tau is."""
        return None if (tau := self.settling_tau) is None else float(self.cost_to_go.law.clock.time(tau))

    @property
    def error(self) -> float:
        """The largest error of x against Dijkstra's algorithm, see :func:`planner.gabf.max_error`."""
        return max_error(self.cost_to_go, oracle(self.cost_to_go.network))


def heal(net: Network, x: Floats, law: Law | str | None = None, since_tau: float = 0.0, **options: Any) -> Healing:
    """Return the field of ``net`` from states ``x`` (n,) of another network, see :func:`raise_start`.

    ``since_tau`` 0 starts a new clock, as is needed after T_p, where the gain is zero. The reading of a clock that
    still runs (``result.end_tau`` of a run that ``until_tau`` ended) lets the change act within that clock: in tau the
    equation is autonomous, so only the settling time changes. ``options`` are those of :func:`planner.gabf.solve`.
    Raises AssumptionError for a law that needs strict overestimates.
    """
    if not (math.isfinite(since_tau) and since_tau >= 0):
        raise OptionError(f"since_tau must be finite and at least 0, got {since_tau}: give the reading of a clock.")
    if (law := resolve_law(law)).needs_overestimate:
        remedy = "start again with solve(net, law), or use the SingularityFree law."
        raise AssumptionError(f"the {law.name} law needs starts above x*, but most of a field is at x*: {remedy}")
    start, before = raise_start(net, x), np.asarray(x, dtype=np.float64)
    result = solve(net, law, x0=start, **options)
    raised, moved = (np.flatnonzero(np.isfinite(result.x) & (now != before)) for now in (start, result.x))
    return Healing(result, frozen(raised, np.int64), frozen(moved, np.int64), since_tau)


def raise_start(net: Network, x: Floats) -> Floats:
    """Return overestimates (n,) of x* that keep ``x`` (n,) where a chain of arcs to a source supports it.

    An arc (i, j) supports x_i if f_i(x_j, w_ij) <= x_i. Along such arcs from the sources on, x_i >= x_i* follows from
    x_j >= x_j* as f is increasing. The other nodes, the subtree that relied on arcs that vanished or rose, get the cost
    of the cheapest arc towards the nodes before them, layer by layer: the cost of some path. +inf as in x*. Ours.
    """
    problem = reduce_network(net)
    y = problem.pack(check_states(net, x, "x"))
    with np.errstate(invalid="ignore"):
        supports = problem.arcs(y[problem.heads]) <= y[problem.owners]
    settled = problem.hops_along(supports & np.isfinite(y[problem.owners])) >= 0
    arcs = np.flatnonzero(~settled[problem.owners] & settled[problem.heads])
    while arcs.size:
        owners = problem.owners[arcs]
        offers = problem.arcs.take(arcs)(y[problem.heads[arcs]])
        frontier = np.unique(owners)
        y[frontier], settled[frontier] = np.inf, True
        np.minimum.at(y, owners, offers)
        arcs = np.flatnonzero(np.isin(problem.heads, frontier) & ~settled[problem.owners])
    return problem.unpack(y)
