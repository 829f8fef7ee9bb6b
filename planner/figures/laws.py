"""Figures of the control laws and of the nine-node example, for reports. A door to matplotlib beside ``figures.py``.

Functions take arrays and return the figure; curves are told apart by dash and by shade, so that a black and white
print is readable.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch
from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

from planner import gabf
from planner.base.arrays import Floats
from planner.figures.strokes import MARKS, SHADES, labelled, single, stroke

NodeHistory: TypeAlias = tuple[Floats, Floats, Floats]
"""t (k,) s, state error x - x* (k,) km, control input (k,) km/s of one node."""

ErrorHistory: TypeAlias = tuple[Floats, Floats]
"""t (k,) s and largest state error (k,) km."""

Grid: TypeAlias = Mapping[tuple[str, str], Sequence[tuple[float, float]]]
"""(p1/p2, m1/m2) to one (settling tau, largest input in km/s) a graph."""

_BOUND_MARKS = {
    "corrected": {"marker": "v", "mfc": "white", "color": SHADES[0], "label": "$T_*$ corrected"},
    "printed": {"marker": "x", "mew": 2.0, "color": SHADES[1], "label": "$T_*$ as printed, eq. (fixtime)"},
    "sharp": {"marker": "_", "ms": 16, "mew": 1.6, "color": "black", "label": "$T_*$ sharp"},
    "measured": {"marker": "o", "ms": 4, "color": "black", "label": "measured, one node from $10^{40}$"},
}
_CENTRED: dict[str, Any] = {"ha": "center", "va": "center"}
_OTHER_ARC: dict[str, Any] = {"color": "0.45", "linewidth": 0.9, "linestyle": (0, (4, 2))}
_ARROW: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 13, "shrinkA": 17, "shrinkB": 17}
_LABEL_BOX: dict[str, Any] = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none"}
_FLOOR = 1e-10  # km: smaller errors are drawn here, as a log axis has no zero


def node_histories(rows: Sequence[tuple[str, Mapping[str, NodeHistory]]], node: int, T_p: float) -> Figure:
    """State error (linear, and its size on a log axis) and control input of one node against t, as fig. (comparison).

    Each row of panels is a title and its curves by label. The time axis ends soon after the last curve has settled,
    at T_p at the latest.
    """
    figure = Figure(figsize=(10.5, 3.2 * len(rows)), layout="constrained")
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
            labelled(axes, f"time $t$ (s), $T_p = {T_p:g}$ s", name).set_xlim(0.0, end)
        panels[1].set_ylim(bottom=_FLOOR)
        lines, labels = panels[0].get_legend_handles_labels()
        place = {"loc": "outside upper center", "ncols": len(labels)}
        part.legend(lines, labels, title=title or None, frameon=False, handlelength=3.6, **place)
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


def near_deadline(histories: Mapping[str, ErrorHistory], T_p: float, title: str = "") -> Figure:
    """Largest error against the time left before T_p, both on log axes; T_p is infinitely far to the right."""
    figure, axes = single(7.2, 4.4)
    for k, (label, (t, error)) in enumerate(histories.items()):
        left = T_p - t
        shown = left > 1e-9
        axes.loglog(left[shown], np.maximum(error[shown], _FLOOR), label=label, **stroke(k))
    axes.invert_xaxis()
    labelled(axes, "time left, $T_p - t$ (s)", f"largest state error (km), 0 drawn at {_FLOOR:g}", title)
    axes.legend(frameon=False, handlelength=3.6, loc="center right", bbox_to_anchor=(1.0, 0.32))
    return figure


def fixed_time_bounds(labels: Sequence[str], lines: Mapping[str, Sequence[float]]) -> Figure:
    """T_* printed, corrected and sharp and the measured tau, for each pair of exponents labelled "p1/p2, m1/m2"."""
    figure = Figure(figsize=(8.4, 4.4), layout="constrained")
    axes = figure.add_subplot()
    for name, look in _BOUND_MARKS.items():
        axes.plot(range(len(labels)), lines[name], linestyle="none", **look)
    axes.set_xticks(range(len(labels)), labels, rotation=60, ha="right", rotation_mode="anchor")
    axes.set_xlabel("exponents $p_1/p_2,\\ m_1/m_2$")
    axes.set_ylabel("settling time $\\tau$ ($\\beta_1 = \\beta_2 = 1$)")
    axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.25, axis="y")
    axes.legend(frameon=False, loc="lower right")
    return figure


_NINE_PLACES = dict(
    enumerate(((0, 1), (1.5, 2), (1.5, 0), (3, 1), (3, 3), (5, 3), (5.1, 0), (6.2, 1.3), (8.3, 2)), start=1)
)


def nine_node_graph(network: gabf.Network, found: gabf.Structure) -> Figure:
    """Fig. (example1): an arc i -> j where node i reads node j, its weight beside it, true-parent arcs drawn thick.

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
