"""What beta trades: the front of (Omega, D), and costs against beta. A door to matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from planner.base.errors import OptionError
from planner.base.shares import traded_off
from planner.tradeoff.result import Interval, Tradeoff
from planner.view.figures.strokes import marked, single, stroke

OMEGA, DISTANCE = "manipulability cost $\\Omega$ (no unit)", "distance cost $D$ (no unit)"
BETA = "$\\beta$ (no unit)"

_FAINT: dict[str, Any] = {"color": "0.7", "linewidth": 0.8, "zorder": 1}


def tradeoff_front(tradeoff: Tradeoff) -> Figure:
    """The paths of a trade-off in the plane of their two costs, each with the betas it is optimal for.

    The line is the lower convex hull, which is all that beta can reach. Raises
    :class:`OptionError` where there is no path.
    """
    intervals = _intervals(tradeoff)
    figure, axes = single(6.4, 4.4, OMEGA, DISTANCE)
    omega, distance = ([getattr(i, name) for i in intervals] for name in ("manipulability_cost", "distance_cost"))
    axes.plot(omega, distance, label="optimal for some $\\beta$", zorder=3, **{**marked(0), "markersize": 7})
    for k, interval in enumerate(intervals):
        place = interval.manipulability_cost, interval.distance_cost
        text = f"$\\beta$ {interval.betas}"
        offset, side = ((8, 6), "left") if k % 2 == 0 else ((-8, -13), "right")  # neighbours may lie close
        axes.annotate(text, place, offset, textcoords="offset points", ha=side, fontsize=8)
    axes.margins(x=0.25, y=0.12)
    axes.legend(frameon=False)
    return figure


def cost_envelope(tradeoff: Tradeoff) -> Figure:
    """Total cost against beta: one line a path, (1 - beta) Omega + beta D, and the lower envelope that GABF follows.

    Raises :class:`OptionError` where there is no path.
    """
    intervals = _intervals(tradeoff)
    figure, axes = single(6.4, 4.0, BETA, "$(1 - \\beta)\\,\\Omega + \\beta D$ (no unit)")
    ends = np.array([0.0, 1.0])
    for k, interval in enumerate(intervals):
        axes.plot(ends, _total(interval, ends), label=f"path {k + 1}", **{**stroke(k + 1), "linewidth": 1.1})
    betas = np.array([intervals[0].beta_min, *(interval.beta_max for interval in intervals)])
    costs = [_total(intervals[max(0, k - 1)], beta) for k, beta in enumerate(betas)]
    axes.plot(betas, costs, label="least cost", **{**marked(0), "linewidth": 2.6})
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(bottom=0.0)
    axes.legend(frameon=False, handlelength=3.6)
    return figure


def _intervals(tradeoff: Tradeoff) -> tuple[Interval, ...]:
    if not tradeoff.intervals:
        raise OptionError(f"the trade-off has no path to draw: {tradeoff.outcome.value}")
    return tradeoff.intervals


def _total(interval: Interval, beta: Any) -> Any:
    return traded_off(beta, interval.manipulability_cost, interval.distance_cost)
