"""A share beta of one cost and 1 - beta of another: eq. (finew)."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from planner.base.errors import OptionError, require_number

if TYPE_CHECKING:
    from planner.base.arrays import Floats

Cost = TypeVar("Cost", float, "Floats")


def traded_off(beta: float, omega: Cost, distance: Cost) -> Cost:
    """(1 - beta) omega + beta distance, eq. (finew): the trade-off that all costs of this planner are made by."""
    return (1.0 - beta) * omega + beta * distance


def require_share(beta: float) -> None:
    """Raise :class:`OptionError` unless beta lies in [0, 1]."""
    require_number("beta", beta)
    if not 0.0 <= beta <= 1.0:
        raise OptionError(f"beta {beta:g} is outside [0, 1]: 0 optimises manipulability only, 1 distance only.")
