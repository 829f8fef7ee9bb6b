"""Figures of the tool's paths among obstacles, and of the roadmap there; imports matplotlib."""

from typing import Any, Literal, TypeAlias

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MultipleLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from planner.base.arrays import Floats
from planner.collision.checker import CollisionChecker
from planner.figures.paths import Shown, paths_to_draw, w_label
from planner.figures.style import COLUMN, MARKS, RAMP, SMALL, JournalFigure, journal, stroke
from planner.kinematics.forward import Chain, joint_placements, tool_positions
from planner.kinematics.manipulability import manipulability
from planner.planning.result import Plan
from planner.robot.robot import Robot
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.tradeoff.result import Tradeoff
from planner.trajectory.measure import dense_path
from planner.view.surfaces import capsule_mesh, tube

Polygons: TypeAlias = list[Floats]
"""Corners (k, 3) of flat faces."""

_VIEW = 24.0, -60.0  # elevation and azimuth, degrees
_OBSTACLES: dict[str, Any] = {"facecolor": (0.6, 0.6, 0.6, 0.16), "edgecolor": (0, 0, 0, 0.16), "linewidth": 0.25}
_ARM: dict[str, Any] = {"color": "0.55", "linewidth": 2.0, "solid_capstyle": "round", "zorder": 2}
_EDGES: dict[str, Any] = {"colors": "0.45", "linewidths": 0.3, "alpha": 0.5, "zorder": 3, "rasterized": True}
_DOTS: dict[str, Any] = {"s": 4, "linewidths": 0, "cmap": RAMP, "depthshade": False, "zorder": 4}
_SHARES = np.linspace(0.0, 1.0, 5)[:, None]  # of an edge: the tool's path is drawn straight between them
_HALO = [withStroke(linewidth=2.0, foreground="white")]


@journal
def tool_paths(shown: Shown, shade: Literal["path", "w"] = "path", checker: CollisionChecker | None = None) -> Figure:
    """Draw the tool's paths among the obstacles, and the arm at both ends of the first path.

        planner.figures.tool_paths({"beta 0": plan, "beta 1": other}).savefig("tool.pdf")
        planner.figures.tool_paths(tradeoff, shade="w")

    Arguments and errors as of :func:`~planner.figures.manipulability`. Dots are waypoints; with ``shade="w"`` a line is
    lighter where w is higher. The arm is a line through its joints.
    """
    drawn = paths_to_draw(shown, checker)
    robot, dense = drawn[0].checker.robot, [dense_path(way.path) for way in drawn]
    lines, arms = [tool_positions(robot, q) for q in dense], [_arm(robot, q) for q in drawn[0].path[[0, -1]]]
    figure, axes = _panel(drawn[0].checker, np.concatenate([*lines, *arms]))
    for arm in arms:
        axes.plot(*arm.T, **_ARM)
    top = max(float(manipulability(robot, q).max()) for q in dense)
    for k, (way, q, line) in enumerate(zip(drawn, dense, lines, strict=True)):
        if shade == "path":
            axes.plot(*line.T, label=way.label, zorder=4 + k, **stroke(k))
            look = {"color": stroke(k)["color"], "markersize": 2.5, "zorder": 4 + k}
            axes.plot(*tool_positions(robot, way.path).T, MARKS[k % 7], **look)
            continue
        shaded: Any = {"cmap": RAMP, "norm": Normalize(0.0, top), "linewidths": 1.8, "capstyle": "round"}
        pieces = Line3DCollection(np.stack([line[:-1], line[1:]], axis=1), zorder=4 + k, **shaded)
        pieces.set_array(manipulability(robot, q[1:]))
        axes.add_collection3d(pieces)
    _mark(axes, "start", lines[0][:1])
    _mark(axes, "goal", lines[0][-1:])
    if shade == "w":
        _add_bar(figure, robot, axes.collections[-1])
    elif drawn[0].label:
        figure.legend(*axes.get_legend_handles_labels(), loc="upper right", ncols=1)
    return figure


@journal
def roadmap(shown: Plan | Tradeoff) -> Figure:
    """Draw the roadmap in the workspace: tool positions of nodes by w, and tool paths of edges.

        planner.figures.roadmap(plan).savefig("roadmap.pdf")

    A lighter node has a higher w. The paths are drawn over it, if any. Edges are pixels in a PDF, at the ``dpi`` given
    to ``savefig``.
    """
    robot, roadmap = shown.robot, shown.roadmap
    nodes = tool_positions(robot, roadmap.nodes)
    figure, axes = _panel(shown.checker, np.concatenate([nodes, _arm(robot, robot.home)]))
    a, b = roadmap.nodes[roadmap.edges.T]
    q = a[:, None] + _SHARES * robot.difference(a, b)[:, None]
    edges = tool_positions(robot, q.reshape(-1, robot.dof)).reshape(*q.shape[:2], 3)
    axes.add_collection3d(Line3DCollection(edges, **_EDGES))
    dots = axes.scatter(*nodes.T, c=roadmap.manipulability, **_DOTS)
    for way in paths_to_draw(shown) if shown.solved else []:
        line = tool_positions(robot, dense_path(way.path)).T
        axes.plot(*line, color="white", linewidth=2.8, zorder=5)
        axes.plot(*line, color="black", linewidth=1.4, zorder=6)
    _mark(axes, "start", nodes[roadmap.starts])
    _mark(axes, "goal", nodes[roadmap.goals])
    _add_bar(figure, robot, dots)
    return figure


def _panel(checker: CollisionChecker, points: Floats) -> tuple[Figure, Any]:
    """Return a figure of the workspace around points (k, 3), from above for a planar arm."""
    figure = JournalFigure(figsize=(COLUMN, 2.6))
    axes: Any = figure.add_subplot(projection="3d", computed_zorder=False)
    figure.subplots_adjust(left=-0.05, right=0.78, bottom=0.06, top=1.02)
    low, high, planar = points.min(axis=0), points.max(axis=0), checker.robot.jacobian_rows == "planar"
    size = np.maximum(1.12 * (high - low), 0.7 * (high - low).max())
    low, high = 0.5 * (low + high - size), 0.5 * (low + high + size)
    step = 0.1 if size.max() < 0.8 else 0.2 if size.max() < 1.2 else 0.4
    for name, a, b in zip("xyz", low, high, strict=True):
        axes.set(**{f"{name}lim": (a, b)})
        getattr(axes, f"set_{name}label")(f"{name} (m)", labelpad=-1 if planar else -6)
        getattr(axes, f"{name}axis").set_major_locator(MultipleLocator(step))
    axes.tick_params(labelsize=SMALL, pad=1 if planar else -2)
    axes.set_box_aspect(size)
    axes.view_init(*_VIEW)
    faces = [face for item in checker.world.scene.obstacles for face in faces_of(item.shape, item.placement)]
    shown = [cut for face in faces if len(cut := clip_face(face, low, high))]
    axes.add_collection3d(Poly3DCollection(shown, zorder=1, **_OBSTACLES))
    if planar:
        axes.view_init(90.0, -90.0)
        axes.set_proj_type("ortho")
        axes.set(zticks=[], zlabel="")
    return figure, axes


def _add_bar(figure: Figure, robot: Robot, shaded: Any) -> None:
    """Draw the scale of w on the right side of the figure."""
    bar = figure.colorbar(shaded, cax=figure.add_axes((0.825, 0.22, 0.017, 0.56)))
    bar.set_label(w_label(robot))
    bar.ax.tick_params(labelsize=SMALL)


def _mark(axes: Any, name: str, places: Floats) -> None:
    """Draw the start white, the goal black, at points (k, 3), and name the first one."""
    fill, text, look = "black", f"{name}   ", {"ha": "right"}
    if name == "start":  # below it: the ticks of z are often on its right
        fill, text, look = "white", f"\n{name}", {"ha": "center", "va": "top"}
    axes.plot(*places.T, "o", color="black", markersize=5, mfc=fill, linestyle="none", zorder=40)
    axes.text(*places[0], text, zorder=41, path_effects=_HALO, **look)


def _arm(robot: Robot, q: Floats) -> Floats:
    """Return points (joints + 2, 3) from the base through the joints to the tool."""
    joints = joint_placements(Chain.from_arm(robot), q[None])[1][:, 0]
    return np.vstack([robot.base[:3, 3], joints[1:], tool_positions(robot, q)])


def faces_of(shape: Shape, placement: Floats) -> Polygons:
    """Return the surface of a shape as flat faces in the world; round shapes have 20 sides."""
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


def clip_face(face: Floats, low: Floats, high: Floats) -> Floats:
    """Return the part (k, 3) of a convex face within a box, Sutherland and Hodgman 1974."""
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
