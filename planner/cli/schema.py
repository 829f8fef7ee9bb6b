"""``planner schema``."""

from __future__ import annotations

import json
from typing import Literal

import tyro

from planner.cli.common import Debug
from planner.cli.terminal import say

Format = Literal["plan", "sweep", "scene", "robot"]


def schema(file: tyro.conf.Positional[Format], debug: Debug = False) -> int:
    """Print the JSON schema of a file: what plan.json and sweep.json hold, what scene and robot files may hold.

    planner schema scene > scene.schema.json

    A scene or robot file is YAML; editors check it by such a schema while it is written.

    Args:
        file: Which file.
    """
    import pydantic

    text = pydantic.TypeAdapter(_model(file)).json_schema(mode="validation")
    say(json.dumps(text, indent=2, ensure_ascii=False))
    return 0


def _model(file: Format) -> type:
    match file:
        case "plan":
            from planner.planning.record import PlanRecord

            return PlanRecord
        case "sweep":
            from planner.tradeoff.schema import SweepRecord

            return SweepRecord
        case "scene":
            from planner.models.scene import SceneFile

            return SceneFile
        case "robot":
            from planner.models.files.robot_files import RobotFile

            return RobotFile
