"""Figures of the states of the dynamics; imports matplotlib."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.errors import OptionError
from planner.figures.style import PAGE, journal, label_axes, sheet, single, stroke

_SHOWN = 40
_FLOOR = 1e-10  # smaller errors are drawn as this one: a log axis has no zero
_DEADLINE: dict[str, Any] = {"color": "black", "linewidth": 1.4, "linestyle": "-"}
_SETTLED: dict[str, Any] = {"color": "black", "linewidth": 1.1, "linestyle": (0, (1, 1.5))}


@journal
def convergence(results: Mapping[str, gabf.CostToGo], nodes: Ints | None = None, unit: str = "no unit") -> Figure:
    """Draw x_i(t) of some nodes, one panel per result by label, with T_p and the settling time.

    x_i* are the end points. ``nodes``: the nodes to draw, by default 40 spread over the range of x*. A light line ends
    low, a dark one high. ``unit`` is that of the network's costs. Raises :class:`OptionError` for a result that was
    solved without ``save``.
    """
    columns = min(2, len(results))
    rows = math.ceil(len(results) / columns)
    figure = sheet(0.5 * PAGE * columns, 2.3 * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, (label, result) in zip(panels, results.items(), strict=False):
        history = _history(label, result)
        chosen = _spread_nodes(result.x) if nodes is None else np.asarray(nodes)
        t, x, deadline = history.t, history.x[:, chosen], result.law.prescribed_time
        if deadline is not None:  # until then settled nodes rest
            t, x = np.append(t, deadline), np.vstack([x, x[-1:]])
        for k, column in enumerate(x.T):
            axes.plot(t, column, color=str(0.75 - 0.7 * k / max(1, len(chosen) - 1)), linewidth=0.9)
        if deadline is not None:
            axes.axvline(deadline, label="$T_p$", **_DEADLINE)
        if result.settling_time is not None:
            axes.axvline(result.settling_time, label="every node settled", **_SETTLED)
        label_axes(axes, "time $t$ (s)", f"state $x_i$ ({unit})", label)
        axes.set_xlim(0.0, 1.02 * t[-1])
    for axes in panels[len(results) :]:
        axes.set_axis_off()
    lines: dict[str, Any] = {}
    for axes in panels:
        lines |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(list(lines.values()), list(lines), loc="outside upper center", ncols=3)
    return figure


@journal
def error_decay(results: Mapping[str, gabf.CostToGo], unit: str = "no unit") -> Figure:
    """Draw the largest |x_i - x_i*| over the nodes against t on a log axis, with T_p.

    x* is Dijkstra's; an error below 1e-10 is drawn there. The time axis ends at one and a half of the latest T_p, if
    any result has one. Raises :class:`OptionError` for a result that was solved without ``save``.
    """
    figure, axes = single(0.6 * PAGE, 2.6, "time $t$ (s)", f"largest $|x_i - x_i^*|$ ({unit})")
    for k, (label, result) in enumerate(results.items()):
        history = _history(label, result)
        x_star = gabf.oracle(result.network)
        known = np.isfinite(x_star)
        error = np.abs(history.x[:, known] - x_star[known]).max(axis=1)
        axes.semilogy(history.t, np.maximum(error, _FLOOR), label=label, **stroke(k))
    deadlines = sorted({r.law.prescribed_time for r in results.values() if r.law.prescribed_time is not None})
    for T in deadlines:
        axes.axvline(T, label=f"$T_p = {T:g}$ s", **_DEADLINE)
    axes.set_xlim(0.0, 1.5 * deadlines[-1] if deadlines else None)
    axes.legend()
    return figure


def _history(label: str, result: gabf.CostToGo) -> gabf.FieldHistory:
    if result.history is None:
        raise OptionError(f"'{label}' has no history to draw: solve with save_every=1.")
    return result.history


def _spread_nodes(x: Floats) -> Ints:
    """Return up to 40 nodes, their final states ascending and spread evenly by rank."""
    order = np.argsort(x, kind="stable")[: int(np.isfinite(x).sum())]
    return order[np.unique(np.linspace(0, len(order) - 1, _SHOWN).round().astype(np.int64))]
