"""A planning problem as MoveIt's messages, and how it is planned."""

import json
from pathlib import Path

import numpy as np

from planner.problem.request import PlanRequest
from tests.worlds import load

PLAIN = PlanRequest.from_options(robot="planar_2r", nodes=40, collision="coal")


def write_problem(folder: Path, number: str, start: tuple[float, float], goal: tuple[float, float]) -> None:
    """planar_2r around a post, as MoveIt's messages."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"scene{number}.yaml").write_text(
        "name: post\nworld:\n  collision_objects:\n    - id: post\n      primitives:\n"
        "        - {type: box, dimensions: [0.1, 0.02, 0.2]}\n      primitive_poses:\n"
        "        - {position: [0.75, 0, 0], orientation: [0, 0, 0, 1]}\n"
    )
    names = load("planar_2r").joints
    goals = "".join(f"      - {{joint_name: {n}, position: {v}}}\n" for n, v in zip(names, goal, strict=True))
    (folder / f"request{number}.yaml").write_text(
        f"start_state:\n  joint_state:\n    name: [{', '.join(names)}]\n    position: [{start[0]}, {start[1]}]\n"
        f"goal_constraints:\n  - joint_constraints:\n{goals}"
    )


def write_cell(folder: Path) -> None:
    """Write a cell of two Pandas as the benchmark reads it, with three states, in one of which they touch."""
    places = ("a", -0.5, 0.0), ("b", 0.5, np.pi)
    robots = [{"name": name, "robot": "panda", "position": [x, 0, 0], "yaw": yaw} for name, x, yaw in places]
    sides = {"one": 0.7, "two": 0.5, "touch": 0.0}
    states = {name: [[side, 0.5, 0, -1.7, 0, 2.2, 0.8]] * 2 for name, side in sides.items()}
    table = {"name": "table", "size": [2, 1, 0.1], "position": [0, 0, -0.06]}
    cell = {"name": "pair", "robots": robots, "boxes": [table], "states": states, "carried_rod": None}
    folder.mkdir()
    (folder / "pair.json").write_text(json.dumps(cell))
