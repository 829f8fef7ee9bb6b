"""Figures of the learning simulations, for reports and notebooks. A door to matplotlib beside ``figures.py``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from planner.base.arrays import Floats, Ints
from planner.figures.strokes import DASHES, MARKS, SHADES, labelled, single

_LOOKS: tuple[dict[str, Any], ...] = tuple(
    {"color": SHADES[k], "linestyle": DASHES[dash], "marker": MARKS[k]} for k, dash in enumerate((0, 1, 3))
)
_PATH: dict[str, Any] = {"color": "#c1121f", "linewidth": 2.4, "solid_capstyle": "round", "zorder": 3}
_SHORTEST: dict[str, Any] = {"color": "black", "linewidth": 1.3, "linestyle": (0, (2, 2)), "zorder": 4}
_START: dict[str, Any] = {"marker": "s", "color": "#2e8b57", "markersize": 8, "zorder": 5, "linestyle": "none"}
_GOAL: dict[str, Any] = {"marker": "o", "color": "#c1121f", "markersize": 8, "zorder": 5, "linestyle": "none"}
_SHADES = "Blues"
_LIGHTEST = 0.35  # so that the first weight, 0.5, is pale but can be seen


@dataclass(frozen=True, eq=False)
class GraphPanel:
    """A planning stage on a graph in the plane: ``arcs`` (k, 2) node indices with ``wbar`` (k,), the path's nodes."""

    title: str
    position: Floats
    arcs: Ints
    wbar: Floats
    path: Ints
    shortest: Ints


def learned_paths(rows: Sequence[Sequence[GraphPanel]]) -> Figure:
    """One panel a stage: links shaded by weight, 1 dark, the path in red, the shortest one dashed."""
    columns = len(rows[0])
    figure = Figure(figsize=(2.9 * columns + 0.9, 3.1 * len(rows) + 0.5), layout="constrained")
    panels: Any = figure.subplots(len(rows), columns, squeeze=False)
    shown = [panel for row in rows for panel in row]
    shades: Any = None
    lightest = min(_LIGHTEST, *(float(panel.wbar.min()) for panel in shown))
    for axes, panel in zip(panels.ravel(), shown, strict=True):
        shades = _draw_graph(axes, panel, Normalize(lightest, 1.0))
    figure.colorbar(shades, ax=panels, label="weight $\\bar w_{ij}$", shrink=0.7, pad=0.01)
    kinds = [
        Line2D([], [], label="path", **_PATH),
        Line2D([], [], label="Euclidean shortest path", **_SHORTEST),
        Line2D([], [], label="start", **_START),
        Line2D([], [], label="goal", **_GOAL),
    ]
    figure.legend(handles=kinds, loc="outside lower center", ncols=4, frameon=False)
    return figure


def share_curves(curves: Mapping[str, Sequence[float]], graphs: int) -> Figure:
    """Share of graphs with the shortest path (%) after each training iteration, from before the first one on."""
    figure, axes = single(6.4, 3.8, "training iterations", f"shortest path found (% of {graphs} graphs)")
    for look, (label, shares) in zip(_LOOKS, curves.items(), strict=False):
        axes.plot(range(len(shares)), 100.0 * np.array(shares), label=label, linewidth=1.6, markersize=5, **look)
    axes.set_ylim(0.0, 104.0)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(frameon=False, loc="center right", bbox_to_anchor=(1.0, 0.3))
    return figure


def threshold_scatter(gap: Floats, smallest: Floats, bound: Floats, used: float) -> Figure:
    """The smallest sufficient K and the proved bound of each graph against the gap to its second-shortest path."""
    gap_axis = "second-shortest path less shortest path"
    figure, axes = single(6.4, 4.0, gap_axis, "$K$ from which on the path is shortest")
    axes.loglog(gap, bound, "v", color=_LOOKS[1]["color"], mfc="white", ms=5, label="proved: $W^* + Q^* / (2\\,gap)$")
    axes.loglog(gap, smallest, "o", color=_LOOKS[0]["color"], ms=4, label="smallest $K$")
    axes.axhline(used, color="0.35", linewidth=1.2, linestyle=(0, (5, 2)))
    axes.text(gap.max(), used * 0.75, f"$K = 1/\\beta = {used:g}$", ha="right", va="top", fontsize=9)
    axes.grid(alpha=0.25, which="both")
    axes.legend(frameon=False, loc="upper right", bbox_to_anchor=(1.0, 0.88))
    return figure


def scan_maps(alphas: Sequence[float], betas: Sequence[float], grids: Mapping[str, Floats], graphs: int) -> Figure:
    """Share of shortest paths after the last iteration (%) over alpha and beta, one map a rule; NaN where not tried."""
    figure = Figure(figsize=(3.9 * len(grids) + 0.6, 3.5), layout="constrained")
    panels: Any = figure.subplots(1, len(grids), squeeze=False)
    shades: Any = None
    for axes, (title, grid) in zip(panels[0], grids.items(), strict=True):
        shades = axes.imshow(100.0 * grid, cmap=_SHADES, vmin=0.0, vmax=100.0, aspect="auto", origin="lower")
        for (i, j), share in np.ndenumerate(grid):
            if np.isfinite(share):
                colour = "white" if share > 0.6 else "black"
                axes.text(j, i, f"{100.0 * share:.0f}", ha="center", va="center", color=colour, fontsize=9)
        axes.set_xticks(range(len(betas)), [f"{beta:g}" for beta in betas])
        axes.set_yticks(range(len(alphas)), [f"{alpha:g}" for alpha in alphas])
        axes.set_xlabel("$\\beta$")
        axes.set_ylabel("learning rate $\\alpha$")
        axes.set_title(title, fontsize=10)
    figure.colorbar(shades, ax=panels, label=f"shortest path found\n(% of {graphs} other graphs)", pad=0.02)
    return figure


@dataclass(frozen=True, eq=False)
class CurvePanel:
    """Curves by label, each (roadmaps, executions): the mean over roadmaps is drawn, ``window`` executions averaged.

    ``band``: shade from the least to the greatest roadmap. ``level``: a value to mark with a line.
    """

    title: str
    quantity: str
    curves: Mapping[str, Floats]
    window: int = 1
    band: bool = False
    level: float | None = None
    last: int | None = None


def execution_curves(panels: Sequence[CurvePanel]) -> Figure:
    """Quantities against the number of executions."""
    columns, rows = 2, -(-len(panels) // 2)
    figure = Figure(figsize=(4.7 * columns, 3.2 * rows + 0.4), layout="constrained")
    grid: Any = figure.subplots(rows, columns, squeeze=False)
    for axes, panel in zip(grid.ravel(), panels, strict=False):
        _draw_curves(axes, panel)
    lines, labels = grid[0, 0].get_legend_handles_labels()
    title = "what is believed of edges not yet seen"
    figure.legend(lines, labels, loc="outside lower center", ncols=len(labels), frameon=False, title=title)
    return figure


def _draw_graph(axes: Axes, panel: GraphPanel, norm: Normalize) -> LineCollection:
    darkest_last = np.argsort(panel.wbar, kind="stable")
    ends = panel.position[panel.arcs[darkest_last]]
    lines = LineCollection(list(ends), cmap=_SHADES, norm=norm, linewidths=1.8, zorder=1)
    lines.set_array(panel.wbar[darkest_last])
    axes.add_collection(lines)
    axes.plot(*panel.position.T, "o", color="0.25", markersize=3, zorder=2)
    axes.plot(*panel.position[panel.path].T, **_PATH)
    axes.plot(*panel.position[panel.shortest].T, **_SHORTEST)
    axes.plot(*panel.position[panel.shortest[0]], **_START)
    axes.plot(*panel.position[panel.shortest[-1]], **_GOAL)
    axes.set_title(panel.title, fontsize=9)
    axes.set_aspect("equal")
    axes.set_xticks([0.0, 0.5, 1.0])
    axes.set_yticks([0.0, 0.5, 1.0])
    axes.tick_params(labelsize=7)
    return lines


def _draw_curves(axes: Axes, panel: CurvePanel) -> None:
    for look, (label, values) in zip(_LOOKS, panel.curves.items(), strict=False):
        shown = values[:, : panel.last]
        blocks = [block.mean(axis=1) for block in np.array_split(shown, max(1, shown.shape[1] // panel.window), axis=1)]
        data = np.stack(blocks, axis=1)
        place = (np.arange(data.shape[1]) + 0.5) * shown.shape[1] / data.shape[1] + 0.5
        style: dict[str, Any] = look | {"marker": look["marker"] if data.shape[1] <= 30 else ""}
        axes.plot(place, data.mean(axis=0), label=label, linewidth=1.6, markersize=4, **style)
        if panel.band:
            axes.fill_between(place, data.min(axis=0), data.max(axis=0), color=look["color"], alpha=0.12, linewidth=0)
    if panel.level is not None:
        axes.axhline(panel.level, color="0.35", linewidth=1.0)
    if panel.last is not None:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    labelled(axes, "executions", panel.quantity, panel.title)
