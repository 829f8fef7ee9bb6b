"""``planner schema``."""

from __future__ import annotations

import json
from typing import Any, Literal

import tyro

from planner.cli.common import Debug
from planner.cli.terminal import say

Format = Literal["plan", "sweep", "scene", "robot", "serve"]


def schema(file: tyro.conf.Positional[Format], debug: Debug = False) -> int:
    """Print the JSON schema of a file: what plan.json and sweep.json hold, what scene and robot files may hold.

    A plan.json is of 'planner plan' and 'follow', or of 'planner task'. 'serve' is no file, but what
    a client may ask of 'planner serve'.

    planner schema scene > scene.schema.json

    A scene or robot file is YAML; editors check it by such a schema while it is written.

    Args:
        file: Which file.
    """
    import pydantic

    if file == "serve":
        from planner.serve.messages import schema as requests

        say(json.dumps(requests(), indent=2, ensure_ascii=False))
        return 0
    text = pydantic.TypeAdapter(_model(file)).json_schema(mode="validation")
    say(json.dumps(text, indent=2, ensure_ascii=False))
    return 0


def _model(file: Literal["plan", "sweep", "scene", "robot"]) -> Any:
    match file:
        case "plan":
            from planner.planning.record import PlanRecord
            from planner.tasks.result import TaskPlanRecord

            return PlanRecord | TaskPlanRecord
        case "sweep":
            from planner.tradeoff.result import SweepRecord

            return SweepRecord
        case "scene":
            from planner.robot.scene import SceneFile

            return SceneFile
        case "robot":
            from planner.robot.files.robot_files import RobotFile

            return RobotFile
