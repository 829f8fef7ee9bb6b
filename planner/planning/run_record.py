"""What every written record begins with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from planner.base.formats import FORMAT_VERSION
from planner.base.versions import versions
from planner.problem.outcome import Outcome
from planner.problem.request import Request
from planner.problem.run_schema import Record
from planner.robot.model_checks import notes
from planner.robot.robot import Robot
from planner.robot.scene import Scene


@dataclass(frozen=True, kw_only=True, eq=False)
class RunRecord(Record):
    """How a run ended, what it was asked for, and with which software."""

    format_version: int
    outcome: Annotated[str, Field(description="solved, no_path, too_singular, partly_followed or interrupted")]
    message: Annotated[str, Field(description="the outcome as a sentence, with its reason and the remedy")]
    robot: str
    scene: str
    seed: int
    config: Annotated[dict[str, Any], Field(description="every option")]
    versions: dict[str, str]
    joints: Annotated[list[str], Field(description="the planned ones, in the order of the columns of a path")]
    tool: str
    notes: Annotated[list[str], Field(description="what was noticed about the model and the start")]


def run_record(request: Request, outcome: Outcome, robot: Robot, scene: Scene) -> dict[str, Any]:
    """How the run ended, what it was asked for, and with which software, as plain data."""
    return {
        "format_version": FORMAT_VERSION,
        "outcome": outcome.key,
        "message": outcome.value,
        "robot": robot.name,
        "scene": scene.name,
        "seed": request.values()["seed"],
        "config": request.config(),
        "versions": versions(),
        "joints": list(robot.joints),
        "tool": robot.tool,
        "notes": [note.text for note in notes(robot, scene)],
    }
