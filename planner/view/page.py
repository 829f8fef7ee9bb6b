"""The page: robot, obstacles, roadmap, paths, motions and numbers in one file that opens offline."""

import shlex
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import OptionError, Reason
from planner.collision.checker import CollisionChecker
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import BANDS, measure_name, rows_of, unit_of
from planner.problem.outcome import NoWay, Rows
from planner.problem.request import Request
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot import Robot
from planner.robot.robot_in_scene import notes as noticed
from planner.robot.scene import Scene
from planner.view.canvas import Canvas, render_page
from planner.view.drawing import (
    TOUCHING,
    draw_path,
    draw_roadmap,
    draw_robot,
    draw_rungs,
    draw_scene,
    extent,
    mark_scale,
    moving_data,
    select_part,
    swept_corners,
)
from planner.view.motion import ShownPath, chain_data, configurations_at, joint_data, motion_data, path_shares
from planner.view.surfaces import css_gradient, ramp_stops, tube

_TOOL_LINE, _TOOL_PATH = 0.012, (0.10, 0.55, 0.95, 0.45)  # m: wider than the tube of the path itself
_ALWAYS = ("robot", "scene", "seed")
_SAMPLES = 9  # configurations of each path that the picture has to hold


class Page:
    """A page under construction: robot and scene, then a roadmap, then paths; :meth:`html` is its text.

    The robot is at ``q`` (dof,). ``rows`` are about the planning; those named in ``wrong`` are red. Names in
    ``touching`` are drawn red, as are those that the ``reason`` for no path blames. ``notes`` are on the start,
    ``command`` is the command line of the plan, see :func:`command_line`. ``planned_in`` is the scene of the plan if
    the drawn scene differs.
    """

    def __init__(
        self,
        robot: Robot,
        scene: Scene,
        q: Floats,
        message: str,
        rows: Rows = [],  # noqa: B006 (read only)
        *,
        touching: Collection[str] = (),
        wrong: Collection[str] = (),
        reason: Reason | None = None,
        notes: Collection[str] = (),
        command: str = "",
        planned_in: Scene | None = None,
    ) -> None:
        self.robot, self.scene, self.q, self.canvas = robot, scene, q, Canvas()
        red = frozenset(touching) | (frozenset() if reason is None else reason.names)
        names, bodies = draw_robot(self.canvas, robot, q, red)
        names |= draw_scene(self.canvas, scene, red)
        self._bodies = bodies or robot.bodies
        self._states = [q[None]]
        self._ends: list[Floats] = []  # starts and goals of the roadmap
        self._points = [np.zeros((0, 3))]
        self._nodes: Any = slice(None)
        self._data: dict[str, Any] = {
            "message": message,
            "about": list(rows),
            "names": names,
            "obstacles": [item.name for item in (*scene.obstacles, *scene.moving)],
            "moving": moving_data(scene),
            "touching": sorted(touching),
            "blamed": None if reason is None else reason.kind,
            "wrong": list(wrong),
            "notes": [
                *((note.text, note.grave) for note in noticed(robot, planned_in or scene)),
                *((text, True) for text in notes),
            ],
            "command": command,
            "roadmap": None,
            "cost": None,
            "paths": [],
            "current": 0,
            "beta": None,
            "floor": 0.0,
            "tool_speed": None,
            "curve": [],
            "ramp": ramp_stops(),
            "gradient": css_gradient(),
            "unit": unit_of(robot),
            "rows": [robot.jacobian_rows, *rows_of(robot)],
            "measure": measure_name(robot.measure),
            "gauge": None,
            "scene": scene.name,
            "robot": robot.name,
            "marks": mark_scale(robot),
            "chain": chain_data(robot),
            "joints": joint_data(robot),
        }
        if isinstance(reason, NoWay):
            between = np.array([reason.gap.start_side, reason.gap.goal_side])  # the shortest motion, a blocked one
            draw_path(self.canvas, "gap", robot, between, TOUCHING)

    def add_roadmap(self, roadmap: Roadmap, cost_to_go: Floats | None = None) -> None:
        """Draw a roadmap; ``cost_to_go`` (n,) colours its nodes for paths without their own."""
        self._nodes, edges = select_part(roadmap)
        self._data["roadmap"] = draw_roadmap(self.canvas, roadmap, self.robot, (self._nodes, edges))
        if not edges.all():
            self._data["about"].append(("drawn", f"{int(edges.sum())} of {len(edges)} edges, evenly chosen"))
        self._data["cost"] = self._field(cost_to_go)
        self._ends = [roadmap.nodes[roadmap.starts], roadmap.nodes[roadmap.goals]]
        typical = float(np.median(roadmap.manipulability))
        if typical > 0.0:
            bands = [(name, share * typical) for name, share in BANDS.items()]
            self._data["gauge"] = {"typical": typical, "most": float(roadmap.manipulability.max()), "bands": bands}
        self._points.append(tool_positions(self.robot, roadmap.nodes[self._nodes]))

    def add_paths(
        self,
        paths: Sequence[ShownPath],
        current: int = 0,
        *,
        beta: float | None = None,
        floor: float = 0.0,
        curve: Sequence[tuple[int, float]] = (),
        tool_speed: float | None = None,
    ) -> None:
        """Draw paths; ``paths[current]`` comes first, at ``beta``, with a ``floor`` under w if it is not 0.

        ``curve``: (refinement rounds, best cost). ``tool_speed`` (m/s) is a requested limit.
        """
        for shown in paths:
            self._states.append(
                configurations_at(shown.path, path_shares(shown.path)[0], np.linspace(0.0, 1.0, _SAMPLES))
            )
            self._points.append(tool_positions(self.robot, shown.path))
        self._data |= {
            "paths": [self._path(shown) for shown in paths],
            "current": current,
            "beta": beta,
            "floor": floor,
            "curve": [list(point) for point in curve],
            "tool_speed": tool_speed,
        }

    def add_tool_line(self, points: Floats, radius: float) -> None:
        """Draw a line (k, 3) m for the tool, with the ``radius`` (m) of its tube."""
        line = tube(points, max(radius, _TOOL_LINE), 8)
        self.canvas.shape(f"tool_path/{len(self._points)}", line, np.eye(4), _TOOL_PATH)
        self._points.append(points)

    def add_rungs(self, q: Floats) -> None:
        """Draw solutions (n, dof) of inverse kinematics along such a line."""
        if len(q):
            draw_rungs(self.canvas, self.robot, q)

    def html(self) -> str:
        """Return HTML text that needs only a browser; without paths the robot is at rest."""
        if not self._data["paths"]:
            self._states += self._ends
            self.add_paths([ShownPath(self.q[None], [])])
        q = np.vstack(self._states)
        centre, radius = extent(self.robot, self.scene, self._bodies, q, np.vstack(self._points))
        ways = [tool_positions(self.robot, q), swept_corners(self.robot, self._bodies, q)]
        data = {
            **self._data,
            "centre": centre.round(3).tolist(),
            "radius": round(radius, 3),
            "fit": outermost_points(*ways),
        }
        return render_page(self.canvas, data, f"{self.robot.name} in {self.scene.name}")

    def _path(self, shown: ShownPath) -> dict[str, Any]:
        return {
            "interval": shown.interval,
            "costs": shown.costs,
            "choice": shown.choice,
            "numbers": shown.numbers,
            "cost": self._field(shown.cost_to_go),
            **motion_data(self.robot, shown),
        }

    def _field(self, x: Floats | None) -> list[float | None] | None:
        """Return the rounded cost-to-go of the drawn nodes; None where no goal is reached."""
        if x is None:
            return None
        return [value if np.isfinite(value) else None for value in np.round(x[self._nodes], 4).tolist()]


def outermost_points(*points: Floats) -> list[list[float]]:
    """Return the points (n, 3) that are farthest in some direction, for the page's camera."""
    rows, directions = np.vstack(points), np.random.default_rng(0).normal(size=(3, 200))
    return rows[np.unique((rows @ directions).argmax(axis=0))].round(3).tolist()


def command_line(verb: str, request: Request) -> str:
    """Return the command for ``request`` without its beta, which the page adds, and without defaults."""
    plain, words = type(request)().config(), []
    for name, value in request.config().items():
        if name in _ALWAYS or (name != "beta" and value != plain[name]):
            words += [f"--{name.replace('_', '-')}", *([] if value is True else [str(value)])]
    return f"planner {verb} {shlex.join(words)}"


@dataclass(frozen=True, repr=False)
class InlinePage:
    """A page in a notebook cell, ``height`` pixels high."""

    html: str
    height: int

    def _repr_html_(self) -> str:
        # without allow-same-origin, so that a name in a scene file cannot reach the notebook
        style = f"width:100%;height:{self.height}px;border:0"
        return f'<iframe sandbox="allow-scripts" style="{style}" srcdoc="{escape(self.html)}"></iframe>'

    def __repr__(self) -> str:
        return f"<page of {len(self.html) / 1e6:.1f} MB>"


def show(thing: Any, checker: CollisionChecker | None = None, height: int = 640) -> InlinePage:
    """Return the page of a plan, trade-off, task or roadmap for a notebook cell.

        planner.show(plan)
        planner.show(roadmap, checker)

    A roadmap needs the checker of its world. Raises :class:`OptionError` without one, or for that of another robot.
    """
    if not isinstance(thing, Roadmap):
        return InlinePage(thing.page(), height)
    if checker is None or thing.origin.joints != checker.robot.joints:
        raise OptionError("checker must be of the roadmap's robot, got another or none: use show(roadmap, checker).")
    q = thing.nodes[thing.starts[0] if len(thing.starts) else 0]
    message = f"A roadmap of {len(thing.nodes)} configurations."
    page = Page(checker.robot, checker.world.scene, q, message, [("roadmap", thing.record().text)])
    page.add_roadmap(thing)
    return InlinePage(page.html(), height)
