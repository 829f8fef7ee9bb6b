"""``planner robots``, ``scenes`` and ``schema``: built-in robots and scenes, schemas of files."""

import json as json_text
import textwrap
from collections.abc import Callable
from typing import Annotated, Any, Literal

import tyro
from typing_extensions import Doc

from planner.cli.common import Debug, Json
from planner.cli.terminal import say

Format = Literal["plan", "sweep", "scene", "cell", "robot", "serve"]


def robots(json: Json = False, debug: Debug = False) -> int:
    """List the built-in robots.

    Each has its tool frame, home, joints and limits.
    """
    from planner.base.resources import robot_names

    _list([_robot_record(name) for name in robot_names()], _robot_lines, json)
    return 0


def scenes(json: Json = False, debug: Debug = False) -> int:
    """List the built-in scenes.

    Each has its obstacles and named states. Scenes of published problems, for one robot each, come last.
    """
    from planner.base.resources import list_published_scenes, scene_names

    _list([_scene_record(name) for name in (*scene_names(), *list_published_scenes())], _scene_lines, json)
    return 0


def schema(
    file: Annotated[tyro.conf.Positional[Format], Doc("The kind of file; serve: the messages of 'planner serve'.")],
    debug: Debug = False,
) -> int:
    """Print the JSON schema of a file.

    Editors check scene and robot files (YAML) by such a schema. A plan.json comes from 'planner plan', 'follow' or
    'task'.
    """
    say(json_text.dumps(_schema(file), indent=2, ensure_ascii=False))
    return 0


def _list(records: list[dict[str, Any]], lines: Callable[[dict[str, Any]], list[str]], json: bool) -> None:
    if json:
        say(json_text.dumps(records, indent=1, ensure_ascii=False))
        return
    for record in records:
        for line in (f"{record['name']}: {record['description']}", *(f"  {line}" for line in lines(record))):
            say(textwrap.fill(line, 79, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False))
        say("")


def _robot_record(name: str) -> dict[str, Any]:
    """Return a robot as plain data: rad, or m for slides; continuous joints have no limits."""
    from planner.robot.robot import Robot

    robot = Robot.load(name)
    joints = [
        {
            "name": joint,
            "lower": None if robot.continuous[k] else float(robot.lower[k]),
            "upper": None if robot.continuous[k] else float(robot.upper[k]),
            "unit": "m" if robot.prismatic[k] else "rad",
        }
        for k, joint in enumerate(robot.joints)
    ]
    record = {"name": robot.name, "description": robot.description, "tool": robot.tool_text}
    return record | {"home": robot.home.tolist(), "joints": joints}


def _robot_lines(record: dict[str, Any]) -> list[str]:
    lines = [f"tool frame {record['tool']}", "home q:" + ",".join(f"{value:.6g}" for value in record["home"])]
    for joint in record["joints"]:
        free = joint["lower"] is None
        limits = "turns freely" if free else f"{joint['lower']:9.4f} to {joint['upper']:8.4f} {joint['unit']}"
        lines.append(f"  {joint['name']:<24} {limits}")
    return lines


def _scene_record(name: str) -> dict[str, Any]:
    """Return a scene as plain data; states by robot, each as --start and --goal take it."""
    from planner.robot.scene import Scene

    scene = Scene.load(name)
    states = {robot: dict(states) for robot, states in scene.states.items()}
    obstacles = [obstacle.name for obstacle in scene.obstacles]
    return {"name": scene.name, "description": scene.description, "obstacles": obstacles, "states": states}


def _scene_lines(record: dict[str, Any]) -> list[str]:
    states = [f"{robot}: {', '.join(states)}" for robot, states in record["states"].items()]
    return [f"obstacles: {', '.join(record['obstacles']) or 'none'}", *states]


def _schema(file: Format) -> dict[str, Any]:
    import pydantic

    if file == "serve":
        from planner.serve.messages import schema as requests

        return requests()
    if file == "plan":
        from planner.planning.record import PlanRecord
        from planner.tasks.result import TaskPlanRecord

        model: Any = PlanRecord | TaskPlanRecord
    elif file == "sweep":
        from planner.tradeoff.result import SweepRecord as model
    elif file == "scene":
        from planner.robot.scene import SceneFile as model
    elif file == "cell":
        from planner.robot.cell import CellFile as model
    else:
        from planner.robot.files.robot_files import RobotFile as model
    return pydantic.TypeAdapter(model).json_schema(mode="validation")
