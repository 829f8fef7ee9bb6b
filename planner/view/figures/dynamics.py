"""How the states of the dynamics settle, and paths on a graph whose weights are learned. A door to matplotlib."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.errors import OptionError
from planner.gabf.learning import Stage
from planner.view.figures.paths import labelled, single, stroke

NodeHistory: TypeAlias = tuple[Floats, Floats, Floats]
"""t (k,) s, state error x - x* (k,) km, control input (k,) km/s of one node."""

_SHOWN = 40
_FLOOR = 1e-10  # smaller errors are drawn here: a log axis has no zero
_DEADLINE: dict[str, Any] = {"color": "black", "linewidth": 1.4, "linestyle": "-"}
_SETTLED: dict[str, Any] = {"color": "black", "linewidth": 1.1, "linestyle": (0, (1, 1.5))}


def convergence(results: Mapping[str, gabf.CostToGo], nodes: Ints | None = None, unit: str = "no unit") -> Figure:
    """x_i(t) of some nodes, one panel a result by label, with T_p and the settling time; x_i* are the end points.

    ``nodes``: the nodes to draw, 40 spread over the range of x* where left out. A light line ends low, a dark one
    high. ``unit`` is that of the network's costs. Raises :class:`OptionError` for a result that was solved without
    ``save``.
    """
    columns = min(2, len(results))
    rows = math.ceil(len(results) / columns)
    figure = Figure(figsize=(4.6 * columns, 2.9 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, (label, result) in zip(panels, results.items(), strict=False):
        course = _history(label, result)
        chosen = _spread_nodes(result.x) if nodes is None else np.asarray(nodes)
        t, x, deadline = course.t, course.x[:, chosen], result.law.prescribed_time
        if deadline is not None:  # until then settled nodes rest
            t, x = np.append(t, deadline), np.vstack([x, x[-1:]])
        for k, column in enumerate(x.T):
            axes.plot(t, column, color=str(0.75 - 0.7 * k / max(1, len(chosen) - 1)), linewidth=0.9)
        if deadline is not None:
            axes.axvline(deadline, label="$T_p$", **_DEADLINE)
        if result.settling_time is not None:
            axes.axvline(result.settling_time, label="every node settled", **_SETTLED)
        labelled(axes, "time $t$ (s)", f"state $x_i$ ({unit})", label)
        axes.set_xlim(0.0, 1.02 * t[-1])
    for axes in panels[len(results) :]:
        axes.set_axis_off()
    lines: dict[str, Any] = {}
    for axes in panels:
        lines |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(list(lines.values()), list(lines), loc="outside upper center", ncols=3, frameon=False)
    return figure


def error_decay(results: Mapping[str, gabf.CostToGo], unit: str = "no unit") -> Figure:
    """Largest |x_i - x_i*| over the nodes against t, on a log axis; T_p is marked where a result has one.

    x* is Dijkstra's. The time axis ends at one and a half of the latest T_p, if any result has one. Raises
    :class:`OptionError` for a result that was solved without ``save``.
    """
    figure, axes = single(6.8, 3.8, "time $t$ (s)", f"largest $|x_i - x_i^*|$ ({unit}), 0 drawn at {_FLOOR:g}")
    for k, (label, result) in enumerate(results.items()):
        course = _history(label, result)
        x_star = gabf.oracle(result.network)
        known = np.isfinite(x_star)
        error = np.abs(course.x[:, known] - x_star[known]).max(axis=1)
        axes.semilogy(course.t, np.maximum(error, _FLOOR), label=label, **stroke(k))
    deadlines = sorted({r.law.prescribed_time for r in results.values() if r.law.prescribed_time is not None})
    for T in deadlines:
        axes.axvline(T, label=f"$T_p = {T:g}$ s", **_DEADLINE)
    axes.set_xlim(0.0, 1.5 * deadlines[-1] if deadlines else None)
    axes.legend(frameon=False, handlelength=3.6)
    return figure


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


def _history(label: str, result: gabf.CostToGo) -> gabf.FieldHistory:
    if result.history is None:
        raise OptionError(f"'{label}' has no history to draw: solve with save_every=1.")
    return result.history


def _spread_nodes(x: Floats) -> Ints:
    """Up to 40 nodes, their final states ascending and spread evenly by rank."""
    order = np.argsort(x, kind="stable")[: int(np.isfinite(x).sum())]
    return order[np.unique(np.linspace(0, len(order) - 1, _SHOWN).round().astype(np.int64))]


_PATH: dict[str, Any] = {"color": "#c1121f", "linewidth": 2.4, "solid_capstyle": "round", "zorder": 3}
_SHORTEST: dict[str, Any] = {"color": "black", "linewidth": 1.3, "linestyle": (0, (2, 2)), "zorder": 4}
_START: dict[str, Any] = {"marker": "s", "color": "#2e8b57", "markersize": 8, "zorder": 5, "linestyle": "none"}
_GOAL: dict[str, Any] = {"marker": "o", "color": "#c1121f", "markersize": 8, "zorder": 5, "linestyle": "none"}
_LIGHTEST = 0.35  # so that the first weight, 0.5, is pale and visible


def learned_paths(runs: Mapping[str, Sequence[Stage]], position: Floats, shortest: Ints) -> Figure:
    """Fig. (learning): a row of panels per training run by its label, a panel per planning stage.

    Nodes stand at ``position`` (n, 2), links are shaded by weight, 1 dark; the path of each stage is red, the
    ``shortest`` one (k,), from the same start, is dashed.
    """
    columns = max(map(len, runs.values()))
    figure = Figure(figsize=(2.9 * columns + 0.9, 3.1 * len(runs) + 0.5), layout="constrained")
    panels: Any = figure.subplots(len(runs), columns, squeeze=False)
    lightest = min(_LIGHTEST, *(float(stage.wbar.min()) for stages in runs.values() for stage in stages))
    links: Any = None
    for row, (label, stages) in zip(panels, runs.items(), strict=True):
        for axes, stage in zip(row, stages, strict=True):
            links = _draw_links(axes, stage, position, Normalize(lightest, 1.0))
            excess = _draw_paths(axes, stage.path(int(shortest[0])), position, shortest)
            axes.set_title(f"{label}, iteration {stage.iteration}\n{excess}", fontsize=9)
    figure.colorbar(links, ax=panels, label="weight $\\bar w_{ij}$", shrink=0.7, pad=0.01)
    looks = {"path": _PATH, "Euclidean shortest path": _SHORTEST, "start": _START, "goal": _GOAL}
    kinds = [Line2D([], [], label=label, **look) for label, look in looks.items()]
    figure.legend(handles=kinds, loc="outside lower center", ncols=4, frameon=False)
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
    axes.tick_params(labelsize=7)
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
