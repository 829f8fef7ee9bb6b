"""What a path is to be good for: the trade-off of eq. (finew), and what its two costs are made of; loads no library."""

from __future__ import annotations

from dataclasses import replace

from planner.base.arrays import Cost, traded_off
from planner.problem.options import (
    Beta,
    Charge,
    Distance,
    ManipulabilityCost,
    Metric,
    MinManipulability,
    WCost,
    WhereCharged,
    options,
)

DEFAULT_BETA = 0.5
DEFAULT_COST: ManipulabilityCost = "log"
DEFAULT_METRIC: Metric = "joint"
DEFAULT_CHARGE: Charge = "edges"


@options
class Objective:
    """Minimise (1 - beta) Omega + beta D of a path, eq. (finew), above a ``floor`` under w.

    D is its length by ``metric``: joint motion, or the tool's path. Omega is its ``manipulability_cost``: with
    ``charge`` "edges" integrated along its length, with "nodes" that of the nodes it leads to, as in the paper.
    """

    beta: Beta = DEFAULT_BETA
    manipulability_cost: WCost = DEFAULT_COST
    metric: Distance = DEFAULT_METRIC
    charge: WhereCharged = DEFAULT_CHARGE
    floor: MinManipulability = 0.0

    def at(self, beta: float) -> Objective:
        """The same at another ``beta``."""
        return replace(self, beta=beta)

    def total(self, omega: Cost, distance: Cost) -> Cost:
        """The cost of a motion or a path with so much Omega and D, each normalised."""
        return traded_off(self.beta, omega, distance)
