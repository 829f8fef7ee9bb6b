"""A field that heals, moment by moment, in the plane of an arm's two joints. A door to matplotlib."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from planner.base.arrays import Floats, Ints
from planner.collision.checker import CollisionChecker
from planner.roadmap.roadmap import Roadmap
from planner.view.figures.space import blocked_grid, shaded_nodes

_COLUMNS, _RED = 3, "#c8102e"


def healing_fields(
    checker: CollisionChecker,
    roadmap: Roadmap,
    moments: Mapping[str, Floats],
    settled: Floats,
    lost: Ints,
    path: Floats | None = None,
    resolution: int = 61,
) -> Figure:
    """The field x (n,) at each of ``moments``, by its label, on the nodes of a roadmap for a planar arm.

    Nodes are shaded by x, all panels alike; those that are not yet what they will be once ``settled`` (n,) have red
    rims, edges ``lost`` (k,) are red. Hatched: in collision, in the world of ``checker``, asked on a grid of
    ``resolution`` x ``resolution``. ``path`` (k, 2) is drawn in the last panel.
    """
    robot, rows = checker.robot, -(-len(moments) // _COLUMNS)
    figure = Figure(figsize=(3.6 * _COLUMNS, 3.0 * rows + 0.5), layout="constrained")
    panels = figure.subplots(rows, _COLUMNS, squeeze=False, sharex=True, sharey=True)
    grid = tuple(np.linspace(low, high, resolution) for low, high in zip(robot.lower, robot.upper, strict=True))
    blocked = blocked_grid(checker, *grid).T.astype(float)
    top = max(float(np.max(x, where=np.isfinite(x), initial=0.0)) for x in moments.values())
    dots = None
    for axes, (label, x) in zip(panels.flat, moments.items(), strict=False):
        axes.contourf(*grid, blocked, levels=[0.5, 1.5], colors=["0.85"], hatches=["////"])
        _draw_edges(axes, roadmap, lost)
        dots = _draw_nodes(axes, roadmap, x, settled, top)
        axes.set_title(label, fontsize=10)
    for axes in panels.flat[len(moments) :]:
        axes.set_axis_off()
    if path is not None:
        panels.flat[len(moments) - 1].plot(*path.T, "-", color="black", linewidth=2.2, zorder=6)
    for axes in panels[-1]:
        axes.set_xlabel(f"{robot.joints[0]} (rad)")
    for axes in panels[:, 0]:
        axes.set_ylabel(f"{robot.joints[1]} (rad)")
    if dots is not None:
        figure.colorbar(dots, ax=panels, label="cost-to-go $x$ (no unit)")
    return figure


def _draw_edges(axes: Axes, roadmap: Roadmap, lost: Ints) -> None:
    ends = roadmap.nodes[roadmap.edges]
    axes.add_collection(LineCollection(list(np.delete(ends, lost, axis=0)), colors="0.7", linewidths=0.5, zorder=2))
    axes.add_collection(LineCollection(list(ends[lost]), colors=_RED, linewidths=1.0, zorder=3))


def _draw_nodes(axes: Axes, roadmap: Roadmap, x: Floats, settled: Floats, top: float) -> PathCollection:
    moving = np.isfinite(x) & np.isfinite(settled) & ~np.isclose(x, settled, rtol=1e-9, atol=1e-9)
    axes.scatter(*roadmap.nodes[moving].T, s=44, facecolors="none", edgecolors=_RED, linewidths=1.2, zorder=5)
    return shaded_nodes(axes, roadmap, x, dot=4, zorder=4, norm=Normalize(0.0, top), s=14, linewidths=0.2)
