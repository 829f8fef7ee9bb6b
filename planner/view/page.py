"""The page: robot, obstacles, roadmap, paths, their motion and numbers, in one file that opens offline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.base.files import write_whole
from planner.base.outcome import Outcome
from planner.collision.checker import CollisionChecker
from planner.kinematics.forward import tool_positions
from planner.plan_record import plan_record, summary_rows
from planner.planning import Plan
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.summary import roadmap_record, roadmap_text
from planner.tradeoff.alternatives import (
    MOST_BEYOND,
    W_UNIT,
    Rows,
    ShownPath,
    count_beyond_beta,
    of_tradeoff,
    on_roadmap,
    paths_for_every_beta,
)
from planner.tradeoff.sweep import Tradeoff
from planner.view.canvas import Canvas, render_page
from planner.view.colours import css_gradient, ramp_stops
from planner.view.drawing import draw_path, draw_roadmap, draw_robot, draw_scene, extent
from planner.view.motion import chain_data, configurations_at, joint_data, motion_data, path_shares
from planner.world.robot import Robot, load_visuals
from planner.world.scene import Scene

_LOOKS = 9  # places of each path that the picture is made to hold


@dataclass(frozen=True, eq=False)
class Content:
    """What a page shows; ``paths[current]`` first, at ``beta``.

    ``stands`` (dof,) is where the robot is while there is no path, ``facts`` what is said of it there. ``about`` is
    how all this was made. Names in ``touching`` are drawn red, rows in ``wrong`` (by name) written red.
    """

    robot: Robot
    scene: Scene
    message: str
    stands: Floats
    facts: Rows = field(default_factory=list)
    about: Rows = field(default_factory=list)
    roadmap: Roadmap | None = None
    cost_to_go: Floats | None = None  # shown where no path brings its own
    paths: Sequence[ShownPath] = ()
    current: int = 0
    beta: float | None = None
    floor: float = 0.0  # under w, as it was asked for; 0 for none
    touching: frozenset[str] = frozenset()
    wrong: tuple[str, ...] = ()


def write_plan_page(plan: Plan, path: Path) -> None:
    """Write ``plan.html`` whole or not at all."""
    write_whole(path, plan_page(plan).encode())


def write_sweep_page(tradeoff: Tradeoff, path: Path) -> None:
    """Write ``sweep.html`` whole or not at all."""
    write_whole(path, sweep_page(tradeoff).encode())


def plan_page(plan: Plan) -> str:
    """A plan's page as HTML text, with the paths of all other betas on its roadmap.

    Raises nothing for a plan without a path: the roadmap shows where it stops.
    """
    paths, current = paths_for_every_beta(plan)
    content = Content(
        plan.robot,
        plan.scene,
        plan.outcome.value,
        plan.roadmap.nodes[plan.roadmap.starts[0]],
        about=summary_rows(plan_record(plan)),
        roadmap=plan.roadmap,
        cost_to_go=on_roadmap(plan.layered, plan.cost_to_go),
        paths=paths,
        current=current,
        beta=plan.request.beta,
        floor=plan.request.min_manipulability,
    )
    return page(content)


def sweep_page(tradeoff: Tradeoff) -> str:
    """A trade-off's page as HTML text, whatever part of it is there."""
    paths = of_tradeoff(tradeoff)
    beta = 0.5 if tradeoff.complete else 0.0
    content = Content(
        tradeoff.robot,
        tradeoff.scene,
        _message(tradeoff),
        tradeoff.roadmap.nodes[tradeoff.roadmap.starts[0]],
        about=_about_sweep(tradeoff),
        roadmap=tradeoff.roadmap,
        paths=paths,
        current=next((k for k, shown in enumerate(paths) if shown.interval and beta <= shown.interval[1]), 0),
        beta=beta,
        floor=tradeoff.request.min_manipulability,
    )
    return page(content)


def roadmap_page(roadmap: Roadmap, checker: CollisionChecker) -> str:
    """The page of a roadmap by itself, in the world that ``checker`` knows."""
    world = checker.world
    about = [("roadmap", roadmap_text(roadmap_record(roadmap, 0)))]
    message = f"A roadmap of {len(roadmap.nodes)} configurations."
    stands = roadmap.nodes[roadmap.starts[0] if len(roadmap.starts) else 0]
    return page(Content(world.robot, world.scene, message, stands, about=about, roadmap=roadmap))


def page(content: Content) -> str:
    """HTML text that needs nothing but a browser."""
    robot, canvas = content.robot, Canvas()
    stands = content.paths[content.current].path[0] if content.paths else content.stands
    visuals = load_visuals(robot)
    names = draw_robot(canvas, robot, visuals, stands, content.touching)
    names |= draw_scene(canvas, content.scene, content.touching)
    roadmap = draw_roadmap(canvas, content.roadmap, robot) if content.roadmap else None
    for k, shown in enumerate(content.paths):
        if len(shown.path) > 1:
            draw_path(canvas, f"paths/{k}", robot, shown.path)
    centre, radius = extent(robot, content.scene, visuals or robot.bodies, _poses(content, stands), _points(content))
    data: dict[str, Any] = {
        "message": content.message,
        "about": content.about,
        "names": names,
        "obstacles": [obstacle.name for obstacle in content.scene.obstacles],
        "touching": sorted(content.touching),
        "wrong": content.wrong,
        "roadmap": roadmap,
        "cost": _field(content.cost_to_go),
        "ramp": ramp_stops(),
        "gradient": css_gradient(),
        "unit": W_UNIT[robot.manipulability],
        "floor": content.floor,
        "chain": chain_data(robot),
        "joints": joint_data(robot),
        "paths": _paths(content),
        "current": content.current,
        "beta": content.beta,
        "centre": centre.round(3).tolist(),
        "radius": round(radius, 3),
    }
    return render_page(canvas, data, f"{robot.name} in {content.scene.name}")


def _paths(content: Content) -> list[dict[str, Any]]:
    """Each path with its motion; a robot that stands still is a path of one configuration."""
    shown = content.paths or [ShownPath(content.stands[None], content.facts)]
    return [
        {
            "interval": item.interval,
            "costs": item.costs,
            "numbers": item.numbers,
            "cost": _field(item.cost_to_go),
            **motion_data(content.robot, item.path),
        }
        for item in shown
    ]


def _field(x: Floats | None) -> list[float | None] | None:
    """Cost-to-go as JSON has it: null where no goal is reached."""
    return None if x is None else [round(float(value), 4) if np.isfinite(value) else None for value in x]


def _poses(content: Content, stands: Floats) -> Floats:
    """Where the robot stands, and some of where it goes along its paths."""
    rows = [stands[None]]
    for shown in content.paths:
        rows.append(configurations_at(shown.path, path_shares(shown.path)[0], np.linspace(0.0, 1.0, _LOOKS)))
    return np.vstack(rows)


def _points(content: Content) -> Floats:
    """Where the tool is at the roadmap's nodes and the paths' waypoints."""
    rows = [shown.path for shown in content.paths]
    if content.roadmap is not None:
        rows.append(content.roadmap.nodes)
    return tool_positions(content.robot, np.vstack(rows)) if rows else np.zeros((0, 3))


def _message(tradeoff: Tradeoff) -> str:
    if tradeoff.outcome is not Outcome.SOLVED:
        return tradeoff.outcome.value
    count = len(tradeoff.intervals)
    return "One path is optimal for every β." if count == 1 else f"{count} paths, each optimal in its interval of β."


def _about_sweep(tradeoff: Tradeoff) -> Rows:
    rows = [("roadmap", roadmap_text(roadmap_record(tradeoff.roadmap, tradeoff.edges_removed)))]
    if tradeoff.solves:
        rows.append(("fields solved", str(tradeoff.solves)))
        rows.append(("error against oracle", f"{tradeoff.max_error_vs_oracle:.1e} relative"))
    if tradeoff.front is not None:
        more = "" if tradeoff.front.complete else ", and perhaps more: the search was stopped"
        beyond = count_beyond_beta(tradeoff)
        some = f" ({MOST_BEYOND} of them are drawn)" if beyond > MOST_BEYOND else ""
        rows.append(("non-dominated paths", f"{len(tradeoff.front.points)}, {beyond} of no β{some}{more}"))
    return rows
