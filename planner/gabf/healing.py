"""A disturbed field finds back: the start from the current x, raised only where what x relied on is gone.

From below, x counts up at the pace of the smallest arc cost; from above it falls in as many steps as there are hops. So
states that a change may have left too low are first raised to an overestimate, and all others stay as they are.
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
    """A field that settled again; nodes ``raised`` (k,) were lifted before the run, ``moved`` (m,) have another x now.

    The run's own clock begins at 0; ``since_tau`` is what an earlier clock showed when the network changed.
    """

    cost_to_go: CostToGo
    raised: Ints
    moved: Ints
    since_tau: float

    @property
    def settling_tau(self) -> float | None:
        """When the field settled, on the clock that ran when the network changed."""
        tau = self.cost_to_go.settling_tau
        return None if tau is None else self.since_tau + tau

    @property
    def settling_time(self) -> float | None:
        """The same in seconds: before T_p under a law that has one, as every tau is."""
        return None if (tau := self.settling_tau) is None else float(self.cost_to_go.law.clock.time(tau))

    @property
    def error(self) -> float:
        """The largest error of x against Dijkstra's, see :func:`planner.gabf.max_error`."""
        return max_error(self.cost_to_go, oracle(self.cost_to_go.network))


def heal(net: Network, x: Floats, law: Law | str | None = None, since_tau: float = 0.0, **options: Any) -> Healing:
    """The field of ``net`` from the states ``x`` (n,) that another network left behind, see :func:`raise_start`.

    ``since_tau`` 0 starts a new clock, as is needed after T_p, where the gain is zero. The reading of a clock that
    still runs (``result.end_tau`` of a run that ``until_tau`` ended) lets the change act within that clock: in tau the
    equation is autonomous, so only the date of settling is another. ``options`` are those of
    :func:`planner.gabf.solve`. Raises AssumptionError for a law that needs strict overestimates.
    """
    if not (math.isfinite(since_tau) and since_tau >= 0):
        raise OptionError(f"since_tau is {since_tau}, no reading of a clock: give 0 or more.")
    if (law := resolve_law(law)).needs_overestimate:
        remedy = "start again with solve(net, law), or take the SingularityFree law"
        raise AssumptionError(f"the {law.name} law needs starts above x*, but most of a field is at it: {remedy}")
    start, before = raise_start(net, x), np.asarray(x, dtype=np.float64)
    result = solve(net, law, x0=start, **options)
    raised, moved = (np.flatnonzero(np.isfinite(result.x) & (now != before)) for now in (start, result.x))
    return Healing(result, frozen(raised, np.int64), frozen(moved, np.int64), since_tau)


def raise_start(net: Network, x: Floats) -> Floats:
    """(n,) overestimates of x* that keep ``x`` (n,) wherever a chain of arcs to a source bears it; +inf as in x*.

    An arc (i, j) bears x_i if f_i(x_j, w_ij) <= x_i. Along such arcs from the sources on, x_i >= x_i* follows from x_j
    >= x_j* as f is increasing. The other nodes, the subtree that relied on arcs that vanished or rose, get what the
    cheapest arc towards the nodes before them costs, layer by layer: the cost of some path. Ours.
    """
    problem = reduce_network(net)
    y = problem.pack(check_states(net, x, "x"))
    with np.errstate(invalid="ignore"):
        bears = problem.arcs(y[problem.heads]) <= y[problem.owners]
    settled = problem.hops_along(bears & np.isfinite(y[problem.owners])) >= 0
    arcs = np.flatnonzero(~settled[problem.owners] & settled[problem.heads])
    while arcs.size:
        owners = problem.owners[arcs]
        offers = problem.arcs.take(arcs)(y[problem.heads[arcs]])
        frontier = np.unique(owners)
        y[frontier], settled[frontier] = np.inf, True
        np.minimum.at(y, owners, offers)
        arcs = np.flatnonzero(np.isin(problem.heads, frontier) & ~settled[problem.owners])
    return problem.unpack(y)
