"""Figures that only the paper's simulations need. A door to matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, StrMethodFormatter

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.figures.paths import BETA, DISTANCE, OMEGA
from planner.figures.style import MARKS, PAGE, SMALL, journal, label_axes, sheet, single, stroke, stroke_with_markers
from planner.gabf.learning import Stage

Grid: TypeAlias = Mapping[tuple[str, str], Sequence[tuple[float, float]]]
"""(p1/p2, m1/m2) to one (settling tau, largest input in km/s) per graph."""

NodeHistory: TypeAlias = tuple[Floats, Floats, Floats]
"""t (k,) s, state error x - x* (k,) km, control input (k,) km/s of one node."""

_FLOOR = 1e-10  # smaller errors are drawn here: a log axis has no zero
_CENTRED: dict[str, Any] = {"ha": "center", "va": "center"}
_OTHER_ARC: dict[str, Any] = {"color": "0.45", "linewidth": 0.9, "linestyle": (0, (4, 2))}
_ARROW: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 13, "shrinkA": 17, "shrinkB": 17}
_LABEL_BOX: dict[str, Any] = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none"}
_FAINT: dict[str, Any] = {"color": "0.7", "linewidth": 0.8, "zorder": 1}
_NINE_PLACES = dict(
    enumerate(((0, 1), (1.5, 2), (1.5, 0), (3, 1), (3, 3), (5, 3), (5.1, 0), (6.2, 1.3), (8.3, 2)), start=1)
)


@journal
def nine_node_graph(network: gabf.Network, found: gabf.Structure) -> Figure:
    """Fig. (example1): an arc i -> j where node i reads node j, labelled with its weight, true-parent arcs drawn thick.

    Sources have a double ring; x* is under each node's number.
    """
    figure = sheet(PAGE, 3.7)
    axes = figure.add_subplot()
    true = set(found.true_arcs.tolist())
    for arc in range(network.n_arcs):
        _draw_arc(axes, network, arc, thick=arc in true)
    for node, place in _NINE_PLACES.items():
        source = node - 1 in network.sources
        axes.plot(*place, "o", ms=28, mfc="0.85" if source else "white", mec="black", mew=1.2, zorder=3)
        if source:
            axes.plot(*place, "o", ms=24.5, mfc="none", mec="black", mew=1.2, zorder=3)
        axes.text(*place, f"{node}\n$x^* = {found.x_star[node - 1]:g}$", fontsize=6.5, zorder=4, **_CENTRED)
    kinds = [
        Line2D([], [], color="black", linewidth=2.2, label="arc to a true parent"),
        Line2D([], [], label="other arc", **_OTHER_ARC),
        Line2D([], [], marker="o", color="black", mfc="0.85", ms=11, linestyle="none", label="source"),
    ]
    axes.legend(handles=kinds, loc="upper left")
    axes.set_xlim(-0.6, 8.6)
    axes.set_ylim(-0.6, 3.7)
    axes.set_aspect("equal")
    axes.set_axis_off()
    return figure


@journal
def exponent_summary(grids: Mapping[str, Grid]) -> Figure:
    """Settling tau and largest input against p1/p2, one line a m1/m2; medians with the range over the graphs."""
    figure = sheet(PAGE, 5.0)
    panels = figure.subplots(len(grids), 2, squeeze=False)
    for (start, grid), (settling, inputs) in zip(grids.items(), panels, strict=True):
        _exponent_lines(settling, {key: [tau for tau, _ in pairs] for key, pairs in grid.items()})
        _exponent_lines(inputs, {key: [u for _, u in pairs] for key, pairs in grid.items()})
        settling.set_ylabel("settling time $\\tau$")
        settling.set_ylim(bottom=0.0)
        inputs.set_ylabel("largest input of any node (km/s)")
        _log_axis(inputs)
        for axes in (settling, inputs):
            axes.set_title(f"starts {start} $x^*$")
    for axes in panels[-1]:
        axes.set_xlabel("$p_1/p_2$")
    panels[0, 0].legend(title="$m_1/m_2$", loc="lower right", ncols=2)
    return figure


@journal
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
    figure = sheet(PAGE, 2.6)
    panels = figure.subplots(1, 3)
    for row, (axes, name) in enumerate(zip(panels[:2], (OMEGA, DISTANCE), strict=True)):
        axes.plot(betas, costs[row].T, **_FAINT)
        axes.plot(betas, np.median(costs[row], axis=0), label="GABF, median", **stroke_with_markers(0, linewidth=2.0))
        for k, (label, pair) in enumerate(others.items(), start=1):
            axes.axhline(float(np.median(pair[row])), label=f"{label}, median", **stroke(k))
        label_axes(axes, BETA, name).set_ylim(bottom=0.0)
    panels[0].plot([], [], label="GABF, one roadmap each", **_FAINT)
    lines, labels = panels[0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside upper left", ncols=4)
    axes = label_axes(panels[2], BETA, "cost relative to that at $\\beta = 1$")
    for k, (symbol, ours, theirs) in enumerate(zip(("\\Omega", "D"), costs, printed, strict=True)):
        # what the paper's normalisation leaves comparable
        share = np.median(ours / ours[:, -1:], axis=0)
        axes.plot(betas, share, label=f"${symbol}$, ours (median)", **stroke_with_markers(2 * k, linewidth=1.8))
        axes.plot(betas, theirs / theirs[-1], label=f"${symbol}$, paper", **stroke_with_markers(2 * k + 1))
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.legend()
    for axes in panels:
        axes.set_xticks(betas)
    return figure


@journal
def share_curves(curves: Mapping[str, Sequence[float]], graphs: int) -> Figure:
    """Share of graphs with the shortest path (%) after each training iteration, from before the first one on."""
    figure, axes = single(0.6 * PAGE, 2.6, "training iterations", f"shortest path found (% of {graphs} graphs)")
    for k, (label, shares) in enumerate(curves.items()):
        axes.plot(range(len(shares)), 100.0 * np.array(shares), label=label, **stroke_with_markers(k))
    axes.set_ylim(0.0, 104.0)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(loc="center right", bbox_to_anchor=(1.0, 0.3))
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
    axes.text(*middle, f"{network.weight[arc]:g}", fontsize=7.5, zorder=2, bbox=_LABEL_BOX, **_CENTRED)


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


@journal
def node_histories(rows: Sequence[tuple[str, Mapping[str, NodeHistory]]], node: int, T_p: float) -> Figure:
    """State error (linear, and its size on a log axis) and control input of one node against t, as fig. (comparison).

    Each row of panels is a title and its curves by label. The time axis ends soon after the last curve has settled,
    at T_p at the latest.
    """
    figure = sheet(PAGE, 2.3 * len(rows))
    end = min(T_p, 1.1 * max(history[0][-1] for _, curves in rows for history in curves.values()))
    parts: Any = figure.subfigures(len(rows), 1, squeeze=False)
    for part, (title, curves) in zip(parts[:, 0], rows, strict=True):
        panels = part.subplots(1, 3)
        for k, (label, (t, error, u)) in enumerate(curves.items()):
            t, error, u = np.append(t, T_p), np.append(error, error[-1]), np.append(u, 0.0)  # once settled it rests
            panels[0].plot(t, error, label=label, **stroke(k))
            panels[1].semilogy(t, np.maximum(np.abs(error), _FLOOR), **stroke(k))
            panels[2].plot(t, u, **stroke(k))
        error, u = f"x_{{{node}}} - x_{{{node}}}^*", f"u_{{{node}}}"
        names = f"state error ${error}$ (km)", f"$|{error}|$ (km)", f"control input ${u}$ (km/s)"
        for axes, name in zip(panels, names, strict=True):
            label_axes(axes, f"time $t$ (s), $T_p = {T_p:g}$ s", name).set_xlim(0.0, end)
        panels[1].set_ylim(bottom=_FLOOR)
        lines, labels = panels[0].get_legend_handles_labels()
        place = {"loc": "outside upper center", "ncols": len(labels)}
        part.legend(lines, labels, title=title or None, **place)
    return figure


_PATH: dict[str, Any] = {"color": "#c1121f", "linewidth": 2.4, "solid_capstyle": "round", "zorder": 3}
_SHORTEST: dict[str, Any] = {"color": "black", "linewidth": 1.3, "linestyle": (0, (2, 2)), "zorder": 4}
_START: dict[str, Any] = {"marker": "s", "color": "#2e8b57", "markersize": 8, "zorder": 5, "linestyle": "none"}
_GOAL: dict[str, Any] = {"marker": "o", "color": "#c1121f", "markersize": 8, "zorder": 5, "linestyle": "none"}
_LIGHTEST = 0.35  # so that the first weight, 0.5, is pale and visible


@journal
def learned_paths(runs: Mapping[str, Sequence[Stage]], position: Floats, shortest: Ints) -> Figure:
    """Fig. (learning): a row of panels per training run by its label, a panel per planning stage.

    Nodes stand at ``position`` (n, 2), links are shaded by weight, 1 dark; the path of each stage is red, the
    ``shortest`` one (k,), from the same start, is dashed.
    """
    columns = max(map(len, runs.values()))
    figure = sheet(PAGE, (PAGE / columns + 0.3) * len(runs) + 0.4)
    panels: Any = figure.subplots(len(runs), columns, squeeze=False)
    lightest = min(_LIGHTEST, *(float(stage.wbar.min()) for stages in runs.values() for stage in stages))
    links: Any = None
    for row, (label, stages) in zip(panels, runs.items(), strict=True):
        for axes, stage in zip(row, stages, strict=True):
            links = _draw_links(axes, stage, position, Normalize(lightest, 1.0))
            excess = _draw_paths(axes, stage.path(int(shortest[0])), position, shortest)
            axes.set_title(f"{label}, iteration {stage.iteration}\n{excess}")
    figure.colorbar(links, ax=panels, label="weight $\\bar w_{ij}$", shrink=0.7, pad=0.01)
    looks = {"path": _PATH, "Euclidean shortest path": _SHORTEST, "start": _START, "goal": _GOAL}
    kinds = [Line2D([], [], label=label, **look) for label, look in looks.items()]
    figure.legend(handles=kinds, loc="outside lower center", ncols=4)
    return figure


def _draw_links(axes: Axes, stage: Stage, position: Floats, norm: Normalize) -> LineCollection:
    order = np.argsort(stage.wbar, kind="stable")  # dark ones last, on top
    arcs = np.column_stack([stage.network.tails, stage.network.indices])[order]
    links = LineCollection(list(position[arcs]), cmap="Blues", norm=norm, linewidths=1.8, zorder=1)
    links.set_array(stage.wbar[order])
    axes.add_collection(links)
    axes.plot(*position.T, "o", color="0.25", markersize=3, zorder=2)
    axes.set_aspect("equal")
    axes.set_xticks([0.0, 0.5, 1.0])
    axes.set_yticks([0.0, 0.5, 1.0])
    axes.tick_params(labelsize=SMALL)
    return links


def _draw_paths(axes: Axes, path: Ints, position: Floats, shortest: Ints) -> str:
    """Draw both paths; how much longer the first one is."""
    axes.plot(*position[path].T, **_PATH)
    axes.plot(*position[shortest].T, **_SHORTEST)
    axes.plot(*position[shortest[0]], **_START)
    axes.plot(*position[shortest[-1]], **_GOAL)
    if np.array_equal(path, shortest):
        return "shortest path"
    length, least = (np.linalg.norm(np.diff(position[nodes], axis=0), axis=1).sum() for nodes in (path, shortest))
    return f"{100.0 * (length / least - 1.0):.1f} % too long"
