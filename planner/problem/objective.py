"""What a path is to be good for: the trade-off of eq. (finew), and what its two costs are made of; loads no library."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, get_args

from planner.base.errors import KeywordError, OptionError, choices, require_number
from planner.base.shares import Cost, require_share, traded_off

Metric = Literal["joint", "workspace"]
Charge = Literal["nodes", "edges"]
ManipulabilityCost = Literal["inverse", "log", "linear"]
DEFAULT_BETA = 0.5
DEFAULT_COST: ManipulabilityCost = "log"
DEFAULT_METRIC: Metric = "joint"
DEFAULT_CHARGE: Charge = "edges"


@dataclass(frozen=True)
class Objective:
    """Minimise (1 - beta) Omega + beta D of a path, eq. (finew), above a ``floor`` under w.

    D is its length by ``metric``: joint motion, or the tool's path. Omega is its ``manipulability_cost``: with
    ``charge`` "edges" integrated along its length, with "nodes" that of the nodes it leads to, as in the paper.
    """

    beta: float = DEFAULT_BETA
    manipulability_cost: ManipulabilityCost = DEFAULT_COST
    metric: Metric = DEFAULT_METRIC
    charge: Charge = DEFAULT_CHARGE
    floor: float = 0.0

    def __post_init__(self) -> None:
        require_share(self.beta)
        require_floor(self.floor)
        for what, value, known in (
            ("manipulability cost", self.manipulability_cost, ManipulabilityCost),
            ("metric", self.metric, Metric),
            ("charge", self.charge, Charge),
        ):
            if value not in get_args(known):
                raise OptionError(f"{what} '{value}' not found; {what}s are {choices(get_args(known))}.")

    def at(self, beta: float) -> Objective:
        """The same at another ``beta``."""
        return replace(self, beta=beta)

    def total(self, omega: Cost, distance: Cost) -> Cost:
        """The cost of a motion or a path with so much Omega and D, each normalised."""
        return traded_off(self.beta, omega, distance)


def said_twice(option: str) -> KeywordError:
    """The error for an ``option`` that is given beside the objective that it is a part of."""
    return KeywordError(f"{option} is a part of the objective: say it there, or leave the objective out.")


def require_floor(w: float) -> None:
    """Raise :class:`OptionError` for a floor under w that is none."""
    require_number("min manipulability", w)
    if not 0.0 <= w <= 1e9:
        raise OptionError(f"min manipulability {w:g} is not usable: give a number from 0 to 1e9.")
