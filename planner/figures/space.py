"""Figures of the configuration space of an arm with two joints: collisions, singularities, fields.

This module imports matplotlib.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import OptionError
from planner.collision.checker import CollisionChecker, is_free
from planner.figures.style import COLUMN, PAGE, RAMP, SMALL, journal, label_axes, sheet
from planner.kinematics.manipulability import jacobians
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot import Robot

_HATCHED: dict[str, Any] = {"colors": ["0.85"], "hatches": ["////"]}
_SINGULAR: dict[str, Any] = {"colors": "black", "linestyles": [(0, (6, 2, 1, 2))], "linewidths": 1.0}
_COLUMNS, _RED = 3, "#c8102e"
_ENDS: dict[str, Any] = {"color": "black", "mfc": "white", "mew": 1.0, "ls": "none", "zorder": 7}


@journal
def configuration_space(
    checker: CollisionChecker,
    roadmap: Roadmap,
    cost_to_go: Floats | Mapping[str, Floats],
    path: Floats | None = None,
    *,
    settled: Floats | None = None,
    lost: Ints | None = None,
    resolution: int = 121,
) -> Figure:
    """Draw the roadmap in the plane of the two joints, with nodes shaded by ``cost_to_go`` (n,).

        planner.figures.configuration_space(plan.checker, plan.roadmap, plan.node_costs, plan.path)

    Several fields by their labels get a panel each, shaded alike, and the ``path`` (k, 2) is in the last one. Nodes
    that differ from the field ``settled`` (n,) have red rims; edges ``lost`` (k,) are red. Hatched: in collision, by
    the checker on a grid of ``resolution`` x ``resolution``. Dash-dotted: singular, where the determinant of the
    Jacobian changes its sign. Nodes that reach no goal are grey. Raises :class:`OptionError` for a robot without two
    joints and a Jacobian of two rows.
    """
    robot = checker.robot
    if robot.dof != 2 or robot.jacobian_rows != "planar":
        raise OptionError(f"{robot.name} has {robot.dof} joints: this figure is for an arm with 2 in a plane.")
    fields = cost_to_go if isinstance(cost_to_go, Mapping) else {"": cost_to_go}
    rows, columns = -(-len(fields) // _COLUMNS), min(len(fields), _COLUMNS)
    figure = sheet(COLUMN, 3.0) if len(fields) == 1 else sheet(PAGE, 2.1 * rows + 0.4)
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    grid = tuple(np.linspace(low, high, resolution) for low, high in zip(robot.lower, robot.upper, strict=True))
    blocked, determinant = collision_grid(checker, *grid).T.astype(float), determinant_grid(robot, *grid).T
    top = max(float(np.max(x, where=np.isfinite(x), initial=0.0)) for x in fields.values())
    dots: Any = None
    for axes, (label, x) in zip(panels.flat, fields.items(), strict=False):
        label_axes(axes, title=label).grid(visible=False)
        axes.contourf(*grid, blocked, levels=[0.5, 1.5], **_HATCHED)
        axes.contour(*grid, determinant, levels=[0.0], **_SINGULAR)
        _draw_edges(axes, robot, roadmap, np.zeros(0, dtype=np.int64) if lost is None else lost)
        dots = _draw_nodes(axes, roadmap, x, x if settled is None else settled, Normalize(0.0, top))
        for name, nodes, look, size in (("start", roadmap.starts, "D", 5), ("goal", roadmap.goals, "*", 9)):
            axes.plot(*roadmap.nodes[nodes].T, look, markersize=size, label=name, **_ENDS)
    if path is not None:
        axes = panels.flat[len(fields) - 1]
        axes.plot(*path.T, "-", color="white", linewidth=3.0, zorder=5)
        axes.plot(*path.T, "o-", color="black", linewidth=1.4, markersize=2.5, label="path", zorder=6)
    figure.colorbar(dots, ax=panels, label="cost-to-go $x$ (no unit)").ax.tick_params(labelsize=SMALL)
    _label(figure, panels, len(fields), robot)
    return figure


def _draw_edges(axes: Axes, robot: Robot, roadmap: Roadmap, lost: Ints) -> None:
    a = roadmap.nodes[roadmap.edges[:, 0]]
    lines = np.stack([a, a + robot.difference(a, roadmap.nodes[roadmap.edges[:, 1]])], axis=1)
    axes.add_collection(LineCollection(list(np.delete(lines, lost, axis=0)), colors="0.65", linewidths=0.4, zorder=2))
    axes.add_collection(LineCollection(list(lines[lost]), colors=_RED, linewidths=0.9, zorder=3))


def _draw_nodes(axes: Axes, roadmap: Roadmap, x: Floats, settled: Floats, norm: Normalize) -> PathCollection:
    """Draw nodes that are not settled with rims, those that reach no goal grey, the others shaded."""
    known = np.isfinite(x)
    moving = known & np.isfinite(settled) & ~np.isclose(x, settled, rtol=1e-9, atol=1e-9)
    if moving.any():
        axes.scatter(*roadmap.nodes[moving].T, s=26, facecolors="none", edgecolors=_RED, linewidths=0.9, zorder=4)
    axes.plot(*roadmap.nodes[~known].T, ".", color="0.6", markersize=3, zorder=4)
    look: dict[str, Any] = {"cmap": RAMP.reversed(), "norm": norm, "edgecolors": "black", "linewidths": 0.2}
    return axes.scatter(*roadmap.nodes[known].T, c=x[known], s=9, zorder=4, **look)


def _label(figure: Figure, panels: Any, count: int, robot: Robot) -> None:
    """Label the axes at the left and below, and the legend."""
    for axes in panels.flat[count:]:
        axes.set_axis_off()
    for axes in panels[-1]:
        axes.set_xlabel(f"{robot.joints[0]} (rad)")
    for axes in panels[:, 0]:
        axes.set_ylabel(f"{robot.joints[1]} (rad)")
    axes = panels.flat[count - 1]
    axes.fill_between([], [], color="0.85", hatch="////", label="in collision")
    axes.plot([], [], color="black", linestyle=(0, (6, 2, 1, 2)), linewidth=1.0, label="singular")
    handles, names = axes.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=3 if count == 1 else 5)


def collision_grid(checker: CollisionChecker, first: Floats, second: Floats) -> Bools:
    """Return (a, b) whether the arm collides with its joints at ``first`` (a,) and ``second`` (b,), rad."""
    return np.array([[not is_free(checker, np.array([p, q])) for q in second] for p in first])


def determinant_grid(robot: Robot, first: Floats, second: Floats) -> Floats:
    """Return (a, b) the determinant of the Jacobian at ``first`` (a,) and ``second`` (b,), rad."""
    return np.linalg.det(jacobians(robot, np.array([[p, q] for p in first for q in second]))).reshape(len(first), -1)
