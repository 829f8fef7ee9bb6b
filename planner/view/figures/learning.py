"""Paths on a graph whose weights are learned. A door to matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from planner.base.arrays import Floats, Ints
from planner.gabf.learning import Stage

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
