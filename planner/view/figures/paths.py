"""What happens along paths, where they lead the tool, and what they cost. A door to matplotlib."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D

from planner.base.arrays import Floats, lengths_along, traded_off
from planner.base.errors import OptionError
from planner.collision.checker import CollisionChecker
from planner.kinematics.forward import Chain, joint_placements, tool_positions
from planner.kinematics.manipulability import manipulability, unit_of
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.tradeoff.result import Interval, Tradeoff
from planner.trajectory.measure import dense_path, path_clearance
from planner.view.surfaces import capsule_mesh, tube

DASHES = ("-", (0, (5, 1.5)), (0, (5, 1.2, 1, 1.2)), (0, (1, 1.1)), (0, (8, 2, 2, 2)), (0, (3, 1, 1, 1, 1, 1)))
SHADES = ("#0b2545", "#b23a0e", "#3a7d44", "#8d6aa8", "#8a6d00", "#555555")
MARKS = ("o", "s", "^", "D", "v", "P")


def stroke(k: int) -> dict[str, Any]:
    """The look of the k-th line of a figure; after six they repeat."""
    return {"linestyle": DASHES[k % 6], "color": SHADES[k % 6], "linewidth": 1.5}


def marked(k: int) -> dict[str, Any]:
    """The k-th line's look with a marker at its points."""
    return {**stroke(k), "marker": MARKS[k % 6], "markersize": 4.5, "markerfacecolor": "white"}


def single(width: float, height: float, x: str = "", y: str = "") -> tuple[Figure, Axes]:
    """A figure (inches) of one panel, named as :func:`labelled` does."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, labelled(figure.add_subplot(), x, y)


def labelled(axes: Axes, x: str = "", y: str = "", title: str = "") -> Axes:
    """The panel with the names of its axes, its title and a faint grid."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title, fontsize=10)
    axes.grid(alpha=0.25)
    return axes


def path_profiles(checker: CollisionChecker, paths: Mapping[str, Floats]) -> Figure:
    """w and clearance along joint paths (k, dof), by the label they get, against the joint motion so far (rad).

    w every 0.01 rad, clearance every centimetre of motion. Raises :class:`OptionError` where a path is empty.
    """
    figure = Figure(figsize=(7.2, 5.0), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    robot = checker.robot
    for k, (label, path) in enumerate(paths.items()):
        if not len(path):
            raise OptionError(f"'{label}' has no path to draw: leave it out, or plan with another seed or more nodes.")
        q = dense_path(path)
        upper.plot(lengths_along(q), manipulability(robot, q), label=label, **stroke(k))
        q, clearance = path_clearance(checker, path)
        lower.plot(lengths_along(q), clearance, **stroke(k))
    labelled(upper, y=f"manipulability $w$ ({unit_of(robot)})")
    labelled(lower, "joint motion from the start (rad)", "clearance (m)")
    for axes in (upper, lower):
        axes.set_ylim(bottom=0.0)
        axes.margins(x=0.01)
    figure.legend(loc="outside upper center", ncols=min(4, len(paths)), frameon=False, handlelength=3.6)
    return figure


def clearance_bounds(certified: Floats, measured: Floats) -> Figure:
    """What proofs say of edges against what measuring finds, (m,) metres each: no dot may lie above the diagonal."""
    measured_axis, certified_axis = (
        "smallest clearance measured along the edge (m)",
        "clearance that its proof certifies (m)",
    )
    figure, axes = single(4.8, 4.4, measured_axis, certified_axis)
    end = 1.05 * float(max(certified.max(initial=0.0), measured.max(initial=0.0)))
    axes.plot([0.0, end], [0.0, end], color="0.5", linewidth=1.0, label="equal")
    axes.plot(measured, certified, label="an edge", **{**marked(0), "linestyle": "none"})
    axes.set_aspect("equal")
    axes.legend(frameon=False)
    return figure


Polygons: TypeAlias = list[Floats]
"""Corners (k, 3) of flat faces."""

_VIEW = 24.0, -60.0  # elevation and azimuth, degrees
_OBSTACLES: dict[str, Any] = {"facecolor": (0.6, 0.6, 0.6, 0.16), "edgecolor": (0, 0, 0, 0.16), "linewidth": 0.4}
_BEHIND: dict[str, Any] = {"color": "0.55", "linewidth": 3.0, "solid_capstyle": "round"}


def tool_paths(robot: Robot, scene: Scene, paths: Mapping[str, Floats]) -> Figure:
    """The tool's path along joint paths (k, dof) by label, among the obstacles: left with the arm, right enlarged.

    Dots are waypoints. The arm is drawn as a line through its joints, at the start and at the end of the first path.
    """
    figure = Figure(figsize=(11.0, 5.4))
    drawn = {label: (tool_positions(robot, dense_path(q)), tool_positions(robot, q)) for label, q in paths.items()}
    faces = [face for item in scene.obstacles for face in faces_of(item.shape, item.placement)]
    first = next(iter(paths.values()))
    points, arms = np.concatenate([dense for dense, _ in drawn.values()]), [_arm(robot, q) for q in first[[0, -1]]]
    whole, near = _limits(np.concatenate([points, *arms, *faces])), _limits(points)
    for place, limits in ((121, whole), (122, near)):
        axes: Any = figure.add_subplot(place, projection="3d", computed_zorder=False)
        _frame(axes, limits)
        shown = [cut for face in faces if len(cut := clipped(face, *limits))]
        axes.add_collection3d(Poly3DCollection(shown, zorder=1, **_OBSTACLES))
        for arm in arms if limits is whole else []:
            axes.plot(*arm.T, zorder=2, **_BEHIND)
        for k, (label, (dense, waypoints)) in enumerate(drawn.items()):
            axes.plot(*dense.T, label=label, zorder=4 + k, **{**stroke(k), "linewidth": 2.0})
            axes.plot(*waypoints.T, MARKS[k % 6], color=stroke(k)["color"], markersize=3.5, zorder=4 + k)
        _mark_ends(axes, next(iter(drawn.values()))[0])
        title = f"{robot.name}, scene '{scene.name}'" if limits is whole else "the tool paths, enlarged"
        axes.set_title(title, y=0.98, fontsize=10)
    lines, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="upper center", ncols=4, frameon=False, handlelength=4.0)
    figure.subplots_adjust(left=0.0, right=0.94, bottom=0.03, top=0.94, wspace=0.1)
    return figure


def faces_of(shape: Shape, placement: Floats) -> Polygons:
    """The surface of a shape as flat faces in the world; round ones by 20 sides."""
    match shape:
        case Box(size):
            square = 0.5 * np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])
            sides = [np.roll(square * [1, 1, sign], axis, axis=1) for axis in range(3) for sign in (-1, 1)]
            faces = [side * np.asarray(size) for side in sides]
        case Sphere(radius):
            faces = _triangles(capsule_mesh(Capsule(radius, 1e-6 * radius)))
        case Capsule():
            faces = _triangles(capsule_mesh(shape))
        case Cylinder(radius, length):
            faces = _triangles(tube(np.array([[0, 0, -0.5 * length], [0, 0, 0.5 * length]]), radius, 20))
        case Mesh():
            faces = _triangles(shape)
    return [face @ placement[:3, :3].T + placement[:3, 3] for face in faces]


def _triangles(mesh: Mesh) -> Polygons:
    return list(mesh.vertices[mesh.triangles])


def clipped(face: Floats, low: Floats, high: Floats) -> Floats:
    """The part (k, 3) of a convex flat face inside the box from ``low`` to ``high`` (Sutherland and Hodgman 1974)."""
    for axis in range(3):
        for sign, bound in ((1.0, low[axis]), (-1.0, high[axis])):
            inside = sign * (face[:, axis] - bound)
            corners = []
            for k in range(len(face)):
                if inside[k] * inside[k - 1] < 0:
                    share = inside[k - 1] / (inside[k - 1] - inside[k])
                    corners.append(face[k - 1] + share * (face[k] - face[k - 1]))
                if inside[k] >= 0:
                    corners.append(face[k])
            face = np.reshape(corners, (-1, 3))
    return face


def _arm(robot: Robot, q: Floats) -> Floats:
    """Points (joints + 2, 3) from the base through the joints to the tool."""
    joints = joint_placements(Chain.of(robot), q[None])[1][:, 0]
    return np.vstack([robot.base[:3, 3], joints[1:], tool_positions(robot, q)])


def _mark_ends(axes: Any, tool_path: Floats) -> None:
    for name, place, fill, side in (
        ("start", tool_path[0], "white", "left"),
        ("goal", tool_path[-1], "black", "right"),
    ):
        axes.plot(*place[:, None], "o", color="black", markersize=7, mfc=fill, zorder=20)
        axes.text(*place, f"   {name}   ", fontsize=9, ha=side, zorder=21)


def _limits(points: Floats) -> tuple[Floats, Floats]:
    """Lower and upper corner (3,) of a box around points, with some room."""
    low, high = points.min(axis=0), points.max(axis=0)
    room = 0.06 * float((high - low).max())
    return low - room, high + room


def _frame(axes: Axes3D, limits: tuple[Floats, Floats]) -> None:
    """Equal scales on the three axes, and ticks that leave room for their numbers."""
    size = limits[1] - limits[0]
    step = 0.1 if size.max() < 0.8 else 0.2 if size.max() < 1.2 else 0.4
    for name, a, b in zip("xyz", *limits, strict=True):
        getattr(axes, f"set_{name}lim")(a, b)
        getattr(axes, f"set_{name}label")(f"{name} (m)")
        getattr(axes, f"{name}axis").set_major_locator(MultipleLocator(step))
    axes.set_box_aspect(size)
    axes.view_init(*_VIEW)


OMEGA, DISTANCE = "manipulability cost $\\Omega$ (no unit)", "distance cost $D$ (no unit)"
BETA = "$\\beta$ (no unit)"

_FAINT: dict[str, Any] = {"color": "0.7", "linewidth": 0.8, "zorder": 1}


def tradeoff_front(tradeoff: Tradeoff) -> Figure:
    """The paths of a trade-off in the plane of their two costs, each with the betas it is optimal for.

    The line is the lower convex hull, which is all that beta can reach. Raises
    :class:`OptionError` where there is no path.
    """
    intervals = _intervals(tradeoff)
    figure, axes = single(6.4, 4.4, OMEGA, DISTANCE)
    omega, distance = ([getattr(i, name) for i in intervals] for name in ("manipulability_cost", "distance_cost"))
    axes.plot(omega, distance, label="optimal for some $\\beta$", zorder=3, **{**marked(0), "markersize": 7})
    for k, interval in enumerate(intervals):
        place = interval.manipulability_cost, interval.distance_cost
        text = f"$\\beta$ {interval.betas}"
        offset, side = ((8, 6), "left") if k % 2 == 0 else ((-8, -13), "right")  # neighbours may lie close
        axes.annotate(text, place, offset, textcoords="offset points", ha=side, fontsize=8)
    axes.margins(x=0.25, y=0.12)
    axes.legend(frameon=False)
    return figure


def cost_envelope(tradeoff: Tradeoff) -> Figure:
    """Total cost against beta: one line a path, (1 - beta) Omega + beta D, and the lower envelope that GABF follows.

    Raises :class:`OptionError` where there is no path.
    """
    intervals = _intervals(tradeoff)
    figure, axes = single(6.4, 4.0, BETA, "$(1 - \\beta)\\,\\Omega + \\beta D$ (no unit)")
    ends = np.array([0.0, 1.0])
    for k, interval in enumerate(intervals):
        axes.plot(ends, _total(interval, ends), label=f"path {k + 1}", **{**stroke(k + 1), "linewidth": 1.1})
    betas = np.array([intervals[0].beta_min, *(interval.beta_max for interval in intervals)])
    costs = [_total(intervals[max(0, k - 1)], beta) for k, beta in enumerate(betas)]
    axes.plot(betas, costs, label="least cost", **{**marked(0), "linewidth": 2.6})
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(bottom=0.0)
    axes.legend(frameon=False, handlelength=3.6)
    return figure


def _intervals(tradeoff: Tradeoff) -> tuple[Interval, ...]:
    if not tradeoff.intervals:
        raise OptionError(f"the trade-off has no path to draw: {tradeoff.outcome.value}")
    return tradeoff.intervals


def _total(interval: Interval, beta: Any) -> Any:
    return traded_off(beta, interval.manipulability_cost, interval.distance_cost)
