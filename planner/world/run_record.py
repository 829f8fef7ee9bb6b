"""What every written record begins with."""

from __future__ import annotations

from typing import Any

from planner.base.formats import FORMAT_VERSION
from planner.base.outcome import Outcome
from planner.base.request import RoadmapRequest
from planner.base.versions import versions
from planner.world.plausible import notes
from planner.world.robot import Robot
from planner.world.scene import Scene


def run_record(request: RoadmapRequest, outcome: Outcome, robot: Robot, scene: Scene) -> dict[str, Any]:
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
