"""A small live page for tests: the planar arm and a post in its way."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from planner.live.controller import LiveController
from planner.live.state import Question
from planner.models.scene import Scene
from planner.session.session import Session

SCENE = """
obstacles:
  - {name: post, type: box, size: [0.1, 0.04, 0.2], position: [0.75, 0, 0]}
  - {name: drum, type: cylinder, radius: 0.05, length: 0.2, position: [-0.5, -0.8, 0.1]}
states: {planar_2r: {start: "q:-1.0,0.8", goal: "q:1.0,-0.8"}}
"""


def make_controller(folder: Path, scene: str = SCENE) -> LiveController:
    """Its scene is ``scene.yaml`` in ``folder``, and is saved to ``saved.yaml`` there."""
    file = folder / "scene.yaml"
    file.write_text(scene)
    session = Session("planar_2r", str(file), nodes=80, collision="coal", join_motions=500)
    return LiveController(session, Question("start", "goal", 0.5), lambda: Scene.load(str(file)), folder / "saved.yaml")


def ask(controller: LiveController, **order: Any) -> dict[str, Any]:
    return json.loads(controller.answer(json.dumps({"order": order}).encode()))


def move(controller: LiveController, name: str, *position: float) -> dict[str, Any]:
    return ask(controller, do="move", name=name, position=position, quaternion=[0, 0, 0, 1])


def path_of(answer: dict[str, Any]) -> np.ndarray:
    return np.array(answer["data"]["paths"][0]["waypoints"])
