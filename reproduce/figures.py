"""Figures that only the paper's simulations need. A door to matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, StrMethodFormatter

from planner import gabf
from planner.base.arrays import Floats
from planner.view.figures.paths import BETA, DISTANCE, MARKS, OMEGA, labelled, marked, single, stroke

Grid: TypeAlias = Mapping[tuple[str, str], Sequence[tuple[float, float]]]
"""(p1/p2, m1/m2) to one (settling tau, largest input in km/s) per graph."""

_CENTRED: dict[str, Any] = {"ha": "center", "va": "center"}
_OTHER_ARC: dict[str, Any] = {"color": "0.45", "linewidth": 0.9, "linestyle": (0, (4, 2))}
_ARROW: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 13, "shrinkA": 17, "shrinkB": 17}
_LABEL_BOX: dict[str, Any] = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none"}
_FAINT: dict[str, Any] = {"color": "0.7", "linewidth": 0.8, "zorder": 1}
_NINE_PLACES = dict(
    enumerate(((0, 1), (1.5, 2), (1.5, 0), (3, 1), (3, 3), (5, 3), (5.1, 0), (6.2, 1.3), (8.3, 2)), start=1)
)


def nine_node_graph(network: gabf.Network, found: gabf.Structure) -> Figure:
    """Fig. (example1): an arc i -> j where node i reads node j, labelled with its weight, true-parent arcs drawn thick.

    Sources have a double ring; x* stands under each node's number.
    """
    figure = Figure(figsize=(8.6, 4.4), layout="constrained")
    axes = figure.add_subplot()
    true = set(found.true_arcs.tolist())
    for arc in range(network.n_arcs):
        _draw_arc(axes, network, arc, thick=arc in true)
    for node, place in _NINE_PLACES.items():
        source = node - 1 in network.sources
        axes.plot(*place, "o", ms=33, mfc="0.85" if source else "white", mec="black", mew=1.2, zorder=3)
        if source:
            axes.plot(*place, "o", ms=29, mfc="none", mec="black", mew=1.2, zorder=3)
        axes.text(*place, f"{node}\n$x^* = {found.x_star[node - 1]:g}$", fontsize=7.5, zorder=4, **_CENTRED)
    kinds = [
        Line2D([], [], color="black", linewidth=2.2, label="arc to a true parent"),
        Line2D([], [], label="other arc", **_OTHER_ARC),
        Line2D([], [], marker="o", color="black", mfc="0.85", ms=11, linestyle="none", label="source"),
    ]
    axes.legend(handles=kinds, frameon=False, loc="upper left")
    axes.set_xlim(-0.6, 8.6)
    axes.set_ylim(-0.6, 3.7)
    axes.set_aspect("equal")
    axes.set_axis_off()
    return figure


def exponent_summary(grids: Mapping[str, Grid]) -> Figure:
    """Settling tau and largest input against p1/p2, one line a m1/m2; medians with the range over the graphs."""
    figure = Figure(figsize=(9.0, 6.4), layout="constrained")
    panels = figure.subplots(len(grids), 2, squeeze=False)
    for (start, grid), (settling, inputs) in zip(grids.items(), panels, strict=True):
        _exponent_lines(settling, {key: [tau for tau, _ in pairs] for key, pairs in grid.items()})
        _exponent_lines(inputs, {key: [u for _, u in pairs] for key, pairs in grid.items()})
        settling.set_ylabel("settling time $\\tau$")
        settling.set_ylim(bottom=0.0)
        inputs.set_ylabel("largest input of any node (km/s)")
        _log_axis(inputs)
        for axes in (settling, inputs):
            axes.set_title(f"starts {start} $x^*$", fontsize=10)
    for axes in panels[-1]:
        axes.set_xlabel("$p_1/p_2$")
    panels[0, 0].legend(frameon=False, title="$m_1/m_2$", handlelength=3.6, loc="lower right", ncols=2)
    return figure


def beta_costs(
    betas: Sequence[float],
    costs: tuple[Floats, Floats],
    others: Mapping[str, tuple[Floats, Floats]],
    printed: tuple[Floats, Floats],
) -> Figure:
    """Accumulated costs against beta on several roadmaps: Omega, D, and both relative to beta = 1 with the paper's.

    ``costs``: Omega and D, (roadmaps, betas) each. ``others``: Omega and D (roadmaps,) of paths that know no beta, by
    label. ``printed``: the paper's Omega and D (betas,). Grey lines are single roadmaps, thick ones medians.
    """
    figure = Figure(figsize=(11.0, 3.8), layout="constrained")
    panels = figure.subplots(1, 3)
    for row, (axes, name) in enumerate(zip(panels[:2], (OMEGA, DISTANCE), strict=True)):
        axes.plot(betas, costs[row].T, **_FAINT)
        axes.plot(betas, np.median(costs[row], axis=0), label="GABF, median", **{**marked(0), "linewidth": 2.2})
        for k, (label, pair) in enumerate(others.items(), start=1):
            axes.axhline(float(np.median(pair[row])), label=f"{label}, median", **stroke(k))
        labelled(axes, BETA, name).set_ylim(bottom=0.0)
    panels[0].plot([], [], label="GABF, one roadmap each", **_FAINT)
    lines, labels = panels[0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside upper left", ncols=4, frameon=False, handlelength=3.6)
    axes = labelled(panels[2], BETA, "cost relative to that at $\\beta = 1$")
    for k, (symbol, ours, theirs) in enumerate(zip(("\\Omega", "D"), costs, printed, strict=True)):
        # what the paper's normalisation leaves comparable
        share = np.median(ours / ours[:, -1:], axis=0)
        axes.plot(betas, share, label=f"${symbol}$, ours (median)", **{**marked(2 * k), "linewidth": 2.0})
        axes.plot(betas, theirs / theirs[-1], label=f"${symbol}$, paper", **marked(2 * k + 1))
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.legend(frameon=False, fontsize=8, handlelength=3.6)
    for axes in panels:
        axes.set_xticks(betas)
    return figure


def share_curves(curves: Mapping[str, Sequence[float]], graphs: int) -> Figure:
    """Share of graphs with the shortest path (%) after each training iteration, from before the first one on."""
    figure, axes = single(6.4, 3.8, "training iterations", f"shortest path found (% of {graphs} graphs)")
    for k, (label, shares) in enumerate(curves.items()):
        axes.plot(range(len(shares)), 100.0 * np.array(shares), label=label, **marked(k))
    axes.set_ylim(0.0, 104.0)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(frameon=False, loc="center right", bbox_to_anchor=(1.0, 0.3))
    return figure


def _draw_arc(axes: Axes, network: gabf.Network, arc: int, thick: bool) -> None:
    """The arc with its weight, bent to its right where there is another one in the opposite direction."""
    i, j = int(network.tails[arc]), int(network.indices[arc])
    (x0, y0), (x1, y1) = _NINE_PLACES[i + 1], _NINE_PLACES[j + 1]
    bend = 0.22 if network.arcs_between(j, i).size else 0.0
    look = {"color": "black", "linewidth": 2.2} if thick else _OTHER_ARC
    axes.add_patch(FancyArrowPatch((x0, y0), (x1, y1), connectionstyle=f"arc3,rad={bend}", **_ARROW, **look))
    across = 0.5 * bend
    middle = 0.5 * (x0 + x1) + across * (y1 - y0), 0.5 * (y0 + y1) - across * (x1 - x0)
    axes.text(*middle, f"{network.weight[arc]:g}", fontsize=8.5, zorder=2, bbox=_LABEL_BOX, **_CENTRED)


def _exponent_lines(axes: Axes, cells: Mapping[tuple[str, str], Sequence[float]]) -> None:
    columns = list(dict.fromkeys(p for p, _ in cells))
    for k, m in enumerate(dict.fromkeys(m for _, m in cells)):
        data = np.array([cells[p, m] for p in columns])
        middle = np.median(data, axis=1)
        reach = np.abs(np.stack((data.min(axis=1), data.max(axis=1))) - middle)
        place = np.arange(len(columns)) + 0.08 * (k - 1.5)
        bars = axes.errorbar(place, middle, reach, label=m, marker=MARKS[k], markersize=4, capsize=2, **stroke(k))
        bars[2][0].set_linewidth(0.8)
    axes.set_xticks(range(len(columns)), columns)
    axes.grid(alpha=0.25, axis="y")


def _log_axis(axes: Axes) -> None:
    """A log axis with plain numbers where it spans little, and powers of ten where it spans much."""
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    if high < 1e3 * low:
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0, 7.0)))
        axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
