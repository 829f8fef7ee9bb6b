"""What every written record begins with."""

from __future__ import annotations

from typing import Any

from planner.base.formats import FORMAT_VERSION
from planner.base.versions import versions
from planner.models.model_checks import notes
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.problem.outcome import Outcome
from planner.problem.request import Growth


def run_record(request: Growth, outcome: Outcome, robot: Robot, scene: Scene) -> dict[str, Any]:
    """How the run ended, what it was asked for, and with which software, as plain data."""
    return {
        "format_version": FORMAT_VERSION,
        "outcome": outcome.key,
        "message": outcome.value,
        "robot": robot.name,
        "scene": scene.name,
        "seed": request.seed,
        "config": request.to_dict(),
        "versions": versions(),
        "joints": list(robot.joints),
        "tool": robot.tool,
        "notes": [note.text for note in notes(robot, scene)],
    }
