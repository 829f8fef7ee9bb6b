"""The page of a plan: robot, obstacles, roadmap, path, the motion and the numbers, in one file that opens offline."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from planner.arrays import Floats
from planner.files import write_whole
from planner.kinematics.forward import Chain, joint_placements, tool_positions
from planner.kinematics.manipulability import manipulability
from planner.outcome import Outcome
from planner.path import dense_path
from planner.plan import Plan
from planner.robot import Robot, load_visuals
from planner.scene import Scene
from planner.view.canvas import Canvas, render_page
from planner.view.colours import css_gradient, ramp
from planner.view.surfaces import tube

_OBSTACLE = (0.55, 0.60, 0.68, 0.85)
_PATH, _START, _GOAL = (0.85, 0.25, 0.10, 1.0), (0.15, 0.65, 0.25, 1.0), (0.80, 0.10, 0.15, 1.0)
_FRAMES = 240
_SECONDS_A_RADIAN = 0.8  # how fast the motion is shown


def write_plan_page(plan: Plan, path: Path) -> None:
    """Write ``plan.html`` whole or not at all."""
    write_whole(path, plan_page(plan).encode())


def plan_page(plan: Plan) -> str:
    """The page as HTML text. Raises nothing for a plan without a path: the roadmap shows where it stops."""
    canvas = Canvas()
    joints = draw_robot(
        canvas, plan.robot, plan.path[0] if len(plan.path) else plan.roadmap.nodes[plan.roadmap.starts[0]]
    )
    draw_scene(canvas, plan.scene)
    legends = _draw_roadmap(canvas, plan)
    _draw_ends(canvas, plan)
    if plan.outcome is Outcome.SOLVED:
        canvas.surface("path", tube(tool_positions(plan.robot, dense_path(plan.path, 0.03)), 0.006), _PATH)
    eye, target = _camera(plan)
    data: dict[str, Any] = {
        "message": plan.outcome.value,
        "numbers": _numbers(plan),
        "legends": legends,
        "gradient": css_gradient(),
        "obstacles": [obstacle.name for obstacle in plan.scene.obstacles],
        "joints": joints,
        "motion": _motion(plan) if plan.outcome is Outcome.SOLVED else None,
        "eye": eye,
        "target": target,
    }
    return render_page(canvas, data, f"{plan.robot.name} in {plan.scene.name}")


def draw_robot(canvas: Canvas, robot: Robot, q: Floats) -> list[str]:
    """The robot's bodies under one frame a joint; returns the names of these frames, the fixed base first."""
    names = ["base", *robot.joints]
    for kind, bodies in (("visual", load_visuals(robot)), ("collision", robot.bodies)):
        for k, body in enumerate(bodies):
            rgba = body.color if kind == "visual" else (0.10, 0.55, 0.90, 0.6)
            canvas.shape(f"robot/{names[body.joint]}/{kind}/{k}", body.shape, body.placement, rgba)
    for name, matrix in zip(names[1:], _frames(robot, q[None])[0], strict=True):
        canvas.transform(f"robot/{name}", matrix)
    return names


def draw_scene(canvas: Canvas, scene: Scene) -> None:
    """The obstacles, and a calm background."""
    for k, obstacle in enumerate(scene.obstacles):
        canvas.shape(f"obstacles/{k}", obstacle.shape, obstacle.placement, _OBSTACLE)
    canvas.set("Background", "top_color", [0.93, 0.95, 0.97])
    canvas.set("Background", "bottom_color", [0.78, 0.82, 0.86])
    canvas.set("Axes", "visible", False)


def _frames(robot: Robot, q: Floats) -> Floats:
    """(n, joints, 4, 4) placements of every planned joint's frame."""
    rotation, position = joint_placements(Chain.of(robot), q)
    matrices = np.zeros((*position.shape[:2], 4, 4))
    matrices[..., :3, :3], matrices[..., :3, 3], matrices[..., 3, 3] = rotation, position, 1.0
    return matrices[1:].transpose(1, 0, 2, 3)


def _motion(plan: Plan) -> dict[str, Any]:
    """Frames evenly spaced in joint motion, each the column-major placements of all joints, with w at each."""
    steps = np.linalg.norm(np.diff(plan.path, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.linspace(0.0, along[-1], _FRAMES)
    q = np.column_stack([np.interp(wanted, along, column) for column in plan.path.T])
    columns = _frames(plan.robot, q).transpose(0, 1, 3, 2).reshape(_FRAMES, -1)
    return {
        "frames": np.round(columns, 5).tolist(),
        "w": np.round(manipulability(plan.robot, q), 6).tolist(),
        "seconds": max(2.0, float(along[-1]) * _SECONDS_A_RADIAN),
    }


def _draw_roadmap(canvas: Canvas, plan: Plan) -> dict[str, Any]:
    """Nodes at their tool positions in two colourings, edges along the tool's way; returns the legends."""
    roadmap, robot = plan.roadmap, plan.robot
    positions = tool_positions(robot, roadmap.nodes)
    w = roadmap.manipulability
    shades = ramp(w / max(float(w.max()), 1e-12))
    canvas.points("roadmap/nodes_w", positions, shades, 0.022)
    unit = {"pose": "m³", "translation": "m³", "planar": "m²"}[robot.rows]
    legends = {"w": {"low": "0", "high": f"{w.max():.3f}", "text": f"manipulability w ({unit}) at the tool's place"}}
    if plan.cost_to_go is not None:
        x = np.where(np.isfinite(plan.cost_to_go.x), plan.cost_to_go.x, np.nan)
        high = float(np.nanmax(x)) if np.isfinite(x).any() else 1.0
        canvas.points("roadmap/nodes_cost", positions, ramp(x / max(high, 1e-12)), 0.022)
        legends["cost"] = {"low": "0", "high": f"{high:.2f}", "text": "cost-to-go (no unit); grey reaches no goal"}
    _draw_edges(canvas, plan, shades)
    return legends


def _draw_edges(canvas: Canvas, plan: Plan, shades: Floats, pieces: int = 4) -> None:
    a, b = plan.roadmap.edges.T
    q, delta = plan.roadmap.nodes[a], plan.robot.difference(plan.roadmap.nodes[a], plan.roadmap.nodes[b])
    s = np.linspace(0.0, 1.0, pieces + 1)
    along = tool_positions(plan.robot, (q[:, None] + s[:, None] * delta[:, None]).reshape(-1, plan.robot.dof))
    along = along.reshape(len(a), pieces + 1, 3)
    ends = np.stack([along[:, :-1], along[:, 1:]], axis=2).reshape(-1, 3)
    tint = (1 - s)[:, None] * shades[a][:, None] + s[:, None] * shades[b][:, None]
    colours = np.stack([tint[:, :-1], tint[:, 1:]], axis=2).reshape(-1, 3)
    if len(ends):
        canvas.segments("roadmap/edges", ends, colours)


def _draw_ends(canvas: Canvas, plan: Plan) -> None:
    from planner.shapes import Sphere

    for role, indices, colour in (("start", plan.roadmap.starts, _START), ("goal", plan.roadmap.goals, _GOAL)):
        for k, place in enumerate(tool_positions(plan.robot, plan.roadmap.nodes[indices])):
            matrix = np.eye(4)
            matrix[:3, 3] = place
            canvas.shape(f"{role}/{k}", Sphere(0.022), matrix, colour)


def _camera(plan: Plan) -> tuple[list[float], list[float]]:
    """A point of view from which the robot's workspace fills the picture."""
    base = plan.robot.base[:3, 3]
    positions = tool_positions(plan.robot, plan.roadmap.nodes)
    size = float(np.linalg.norm(positions - base, axis=1).max())
    target = base + np.array([0.0, 0.0, 0.35 * size])
    eye = target + size * np.array([1.7, -2.5, 1.0])
    return eye.round(3).tolist(), target.round(3).tolist()


def _numbers(plan: Plan) -> list[tuple[str, str]]:
    from planner.results import plan_record, summary_rows

    return summary_rows(plan_record(plan))
