"""The configuration space of an arm with two joints: collisions, singular places, fields and how they heal.

A door to matplotlib.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import OptionError
from planner.collision.checker import CollisionChecker, is_free
from planner.kinematics.manipulability import jacobians
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot import Robot
from planner.view.surfaces import ramp_stops

_HATCHED: dict[str, Any] = {"colors": ["0.85"], "hatches": ["////"]}
_SINGULAR: dict[str, Any] = {"colors": "black", "linestyles": [(0, (6, 2, 1, 2))], "linewidths": 1.4}


def configuration_space(
    checker: CollisionChecker, roadmap: Roadmap, cost_to_go: Floats, path: Floats | None = None, resolution: int = 121
) -> Figure:
    """The roadmap in the plane of the two joints, its nodes shaded by ``cost_to_go`` (n,), and a ``path`` (k, 2).

    Hatched: in collision, by asking the checker on a grid of ``resolution`` x ``resolution``. Dash-dotted: singular,
    where the determinant of the Jacobian changes its sign. Nodes that reach no goal are grey. Raises
    :class:`OptionError` for a robot that has not two joints and a Jacobian of two rows.
    """
    robot = checker.robot
    if robot.dof != 2 or robot.jacobian_rows != "planar":
        raise OptionError(f"{robot.name} has {robot.dof} joints: this figure is for an arm with 2 in a plane.")
    figure = Figure(figsize=(7.2, 5.6), layout="constrained")
    axes = figure.add_subplot()
    grid = tuple(np.linspace(low, high, resolution) for low, high in zip(robot.lower, robot.upper, strict=True))
    axes.contourf(*grid, blocked_grid(checker, *grid).T.astype(float), levels=[0.5, 1.5], **_HATCHED)
    axes.contour(*grid, determinant_grid(robot, *grid).T, levels=[0.0], **_SINGULAR)
    _draw_roadmap(figure, axes, robot, roadmap, cost_to_go)
    if path is not None:
        axes.plot(*path.T, "-", color="white", linewidth=4.5, zorder=4)
        axes.plot(*path.T, "o-", color="black", linewidth=2.0, markersize=4, label="path", zorder=5)
    for name, nodes, look, size in (("start", roadmap.starts, "D", 7), ("goal", roadmap.goals, "*", 13)):
        places = roadmap.nodes[nodes].T
        axes.plot(*places, look, color="black", mfc="white", markersize=size, mew=1.6, ls="none", label=name, zorder=6)
    _label(axes, robot, grid)
    return figure


def blocked_grid(checker: CollisionChecker, first: Floats, second: Floats) -> Bools:
    """(a, b) whether the arm collides with its joints at ``first`` (a,) and ``second`` (b,), rad."""
    return np.array([[not is_free(checker, np.array([p, q])) for q in second] for p in first])


def determinant_grid(robot: Robot, first: Floats, second: Floats) -> Floats:
    """(a, b) determinant of the Jacobian with the joints at ``first`` (a,) and ``second`` (b,), rad."""
    return np.linalg.det(jacobians(robot, np.array([[p, q] for p in first for q in second]))).reshape(len(first), -1)


def shaded_nodes(axes: Axes, roadmap: Roadmap, x: Floats, dot: float, **look: Any) -> PathCollection:
    """The roadmap's nodes shaded by ``x`` (n,), with the ``look`` of a scatter; those that reach no goal grey dots."""
    known, shades = np.isfinite(x), LinearSegmentedColormap.from_list("cost", ramp_stops()[::-1])
    axes.plot(*roadmap.nodes[~known].T, ".", color="0.6", markersize=dot, zorder=look["zorder"])
    return axes.scatter(*roadmap.nodes[known].T, c=x[known], cmap=shades, edgecolors="black", **look)


def _draw_roadmap(figure: Figure, axes: Axes, robot: Robot, roadmap: Roadmap, cost_to_go: Floats) -> None:
    a = roadmap.nodes[roadmap.edges[:, 0]]
    b = a + robot.difference(a, roadmap.nodes[roadmap.edges[:, 1]])
    axes.add_collection(LineCollection(list(np.stack([a, b], axis=1)), colors="0.6", linewidths=0.6, zorder=2))
    dots = shaded_nodes(axes, roadmap, cost_to_go, dot=5, zorder=3, s=22, linewidths=0.3)
    figure.colorbar(dots, ax=axes, label="cost-to-go $x$ (no unit)")


def _label(axes: Axes, robot: Robot, grid: tuple[Floats, Floats]) -> None:
    axes.set_xlim(grid[0][0], grid[0][-1])
    axes.set_ylim(grid[1][0], grid[1][-1])
    axes.set_xlabel(f"{robot.joints[0]} (rad)")
    axes.set_ylabel(f"{robot.joints[1]} (rad)")
    axes.fill_between([], [], color="0.85", hatch="////", label="in collision")
    axes.plot([], [], color="black", linestyle=(0, (6, 2, 1, 2)), label="singular")
    axes.figure.legend(loc="outside upper center", ncols=5, frameon=False)


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
