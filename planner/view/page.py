"""The page: robot, obstacles, roadmap, paths, their motion and numbers, in one file that opens offline."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats
from planner.base.errors import Reason
from planner.base.files import write_json, write_whole
from planner.base.progress import Stopwatch
from planner.collision.checker import CollisionChecker
from planner.kinematics.forward import tool_positions
from planner.problem.reasons import NoWay
from planner.roadmap.record_text import roadmap_text
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.view.canvas import Canvas, render_page
from planner.view.colours import css_gradient, ramp_stops
from planner.view.drawing import (
    draw_gap,
    draw_path,
    draw_roadmap,
    draw_rungs,
    draw_scene,
    draw_tool_line,
    drawn_part,
    extent,
    moving_data,
)
from planner.view.motion import chain_data, configurations_at, joint_data, motion_data, path_shares
from planner.view.shown_path import W_UNIT, Rows, ShownPath
from planner.view.visuals import draw_robot

_LOOKS = 9  # places of each path that the picture is made to hold


@dataclass(frozen=True, eq=False)
class Content:
    """What a page shows; ``paths[current]`` first, at ``beta``.

    ``configuration`` (dof,) is where the robot is while there is no path, ``facts`` what is said of it there.
    ``details`` is how all this was made. Names in ``touching`` are drawn red, as is what a ``reason`` blames; rows in
    ``highlighted`` (by name) are written red.
    """

    robot: Robot
    scene: Scene
    message: str
    configuration: Floats
    facts: Rows = field(default_factory=list)
    details: Rows = field(default_factory=list)
    roadmap: Roadmap | None = None
    cost_to_go: Floats | None = None  # shown where no path brings its own
    paths: Sequence[ShownPath] = ()
    current: int = 0
    beta: float | None = None
    floor: float = 0.0  # under w, as it was asked for; 0 for none
    curve: Sequence[tuple[int, float]] = ()  # (rounds of effort, best cost)
    touching: frozenset[str] = frozenset()
    highlighted: tuple[str, ...] = ()
    reason: Reason | None = None  # why there is no path
    tool_lines: Sequence[tuple[Floats, float]] = ()  # points (k, 3) m to be followed, and the tube around them
    rungs: Floats | None = None  # (n, dof), what there was to choose from along such a line

    @cached_property
    def drawn(self) -> tuple[Bools, Bools]:
        """Masks of the roadmap's nodes and edges that are drawn."""
        if self.roadmap is None:
            return np.zeros(0, dtype=bool), np.zeros(0, dtype=bool)
        return drawn_part(self.roadmap)

    @property
    def shown(self) -> Sequence[ShownPath]:
        """The paths; of a robot that stands still one of a single configuration."""
        return self.paths or [ShownPath(self.configuration[None], self.facts)]

    @property
    def notes(self) -> Rows:
        """``details``, and how much of a large roadmap is drawn."""
        count, total = int(self.drawn[1].sum()), len(self.drawn[1])
        return [*self.details, ("drawn", f"{count} of {total} edges, evenly")] if count < total else self.details

    @property
    def red(self) -> frozenset[str]:
        """The names of all that is drawn red."""
        return self.touching if self.reason is None else self.touching | self.reason.names


def roadmap_page(roadmap: Roadmap, checker: CollisionChecker) -> str:
    """The page of a roadmap by itself, in the world that ``checker`` knows."""
    world = checker.world
    details = [("roadmap", roadmap_text(roadmap.record().to_dict()))]
    message = f"A roadmap of {len(roadmap.nodes)} configurations."
    configuration = roadmap.nodes[roadmap.starts[0] if len(roadmap.starts) else 0]
    return page(Content(world.robot, world.scene, message, configuration, details=details, roadmap=roadmap))


def save_page(
    draw: Callable[[], str], page_file: Path, record: dict[str, Any], record_file: Path, clock: Stopwatch
) -> dict[str, Any]:
    """Write the page, and the record again with the seconds of ``clock``; returns that record."""
    with clock("page"):
        write_whole(page_file, draw().encode())
    record = {**record, "timings_s": clock.record()}
    write_json(record_file, record)
    return record


def page(content: Content) -> str:
    """HTML text that needs nothing but a browser."""
    robot, canvas = content.robot, Canvas()
    configuration = content.paths[content.current].path[0] if content.paths else content.configuration
    names, bodies = draw_robot(canvas, robot, configuration, content.red)
    names |= draw_scene(canvas, content.scene, content.red)
    for k, (line, radius) in enumerate(content.tool_lines):
        draw_tool_line(canvas, f"tool_path/{k}", line, radius)
    if content.rungs is not None and len(content.rungs):
        draw_rungs(canvas, robot, content.rungs)
    answer = _draw_answer(canvas, content)
    shares = np.linspace(0.0, 1.0, _LOOKS)
    looks = [configurations_at(shown.path, path_shares(shown.path)[0], shares) for shown in content.paths]
    states = [shown.path for shown in content.paths]
    if content.roadmap is not None:
        states.append(content.roadmap.nodes[content.drawn[0]])
    points = tool_positions(robot, np.vstack(states)) if states else np.zeros((0, 3))
    points = np.vstack([points, *(line for line, _ in content.tool_lines)])
    centre, radius = extent(
        robot, content.scene, bodies or robot.bodies, np.vstack([configuration[None], *looks]), points
    )
    data: dict[str, Any] = {
        **answer,
        "about": content.notes,
        "names": names,
        "obstacles": [item.name for item in (*content.scene.obstacles, *content.scene.moving)],
        "moving": moving_data(content.scene),
        "wrong": content.highlighted,
        "ramp": ramp_stops(),
        "gradient": css_gradient(),
        "unit": W_UNIT[robot.manipulability],
        "floor": content.floor,
        "curve": [list(point) for point in content.curve],
        "chain": chain_data(robot),
        "joints": joint_data(robot),
        "beta": content.beta,
        "centre": centre.round(3).tolist(),
        "radius": round(radius, 3),
    }
    return render_page(canvas, data, f"{robot.name} in {content.scene.name}")


def _draw_answer(canvas: Canvas, content: Content) -> dict[str, Any]:
    """Draw the roadmap, the paths, and the gap where there is no path; returns their data."""
    robot = content.robot
    roadmap = draw_roadmap(canvas, content.roadmap, robot, content.drawn) if content.roadmap else None
    for k, shown in enumerate(content.paths):
        if len(shown.path) > 1:
            draw_path(canvas, f"paths/{k}", robot, shown.path if shown.motion is None else shown.motion.states)
    if isinstance(content.reason, NoWay):
        draw_gap(canvas, robot, content.reason.gap)
    return {
        "message": content.message,
        "touching": sorted(content.touching),
        "blamed": None if content.reason is None else content.reason.kind,
        "roadmap": roadmap,
        "cost": _field(content, content.cost_to_go),
        "paths": [_path(content, shown) for shown in content.shown],
        "current": content.current,
    }


def _path(content: Content, shown: ShownPath) -> dict[str, Any]:
    """A path with its motion."""
    return {
        "interval": shown.interval,
        "costs": shown.costs,
        "numbers": shown.numbers,
        "cost": _field(content, shown.cost_to_go),
        **motion_data(content.robot, shown.path, shown.motion),
    }


def _field(content: Content, x: Floats | None) -> list[float | None] | None:
    """The cost-to-go of the nodes that are drawn, rounded; null where no goal is reached."""
    if x is None:
        return None
    x = x if content.roadmap is None else x[content.drawn[0]]
    return [value if np.isfinite(value) else None for value in np.round(x, 4).tolist()]
