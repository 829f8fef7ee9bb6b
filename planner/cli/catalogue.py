"""``planner robots`` and ``planner scenes``: what is there."""

from __future__ import annotations

import json as json_text
import textwrap
from typing import TYPE_CHECKING, Any

from planner.cli.common import Debug, Flag
from planner.cli.terminal import say

if TYPE_CHECKING:
    from planner.robot.robot import Robot
    from planner.robot.scene import Scene

WIDTH = 79  # columns


def robots(json: Flag = False, debug: Debug = False) -> int:
    """List the robots, with their tool frame, home, joints and limits.

    Args:
        json: Print the list as JSON.
    """
    from planner.base.resources import robot_names
    from planner.robot.robot import Robot

    records = [robot_record(Robot.load(name)) for name in robot_names()]
    say(json_text.dumps(records, indent=1, ensure_ascii=False) if json else "\n\n".join(map(_robot_text, records)))
    return 0


def scenes(json: Flag = False, debug: Debug = False) -> int:
    """List the scenes, with their obstacles and named states; last those of published problems, for one robot each.

    Args:
        json: Print the list as JSON, states as they are written in the scene file.
    """
    from planner.base.resources import published_scene_names, scene_names
    from planner.robot.scene import Scene

    records = [scene_record(Scene.load(name)) for name in (*scene_names(), *published_scene_names())]
    say(json_text.dumps(records, indent=1, ensure_ascii=False) if json else "\n\n".join(map(_scene_text, records)))
    return 0


def robot_record(robot: Robot) -> dict[str, Any]:
    """A robot as plain data; units are rad, or m where a joint slides. Joints that turn freely have no limits."""
    return {
        "name": robot.name,
        "description": robot.description,
        "tool": robot.tool,
        "home": robot.home.tolist(),
        "joints": [
            {
                "name": joint,
                "lower": None if robot.continuous[k] else float(robot.lower[k]),
                "upper": None if robot.continuous[k] else float(robot.upper[k]),
                "unit": "m" if robot.prismatic[k] else "rad",
            }
            for k, joint in enumerate(robot.joints)
        ],
    }


def scene_record(scene: Scene) -> dict[str, Any]:
    """A scene as plain data; states by robot, each as --start and --goal take it."""
    return {
        "name": scene.name,
        "description": scene.description,
        "obstacles": [obstacle.name for obstacle in scene.obstacles],
        "states": {robot: dict(states) for robot, states in scene.states.items()},
    }


def _robot_text(record: dict[str, Any]) -> str:
    home = ",".join(f"{value:.6g}" for value in record["home"])
    lines = [_wrapped(f"{record['name']}: {record['description']}"), _wrapped(f"tool frame {record['tool']}", 2)]
    lines.append(_wrapped(f"home q:{home}", 2))
    for joint in record["joints"]:
        free = joint["lower"] is None
        limits = "turns freely" if free else f"{joint['lower']:9.4f} to {joint['upper']:8.4f} {joint['unit']}"
        lines.append(f"    {joint['name']:<24} {limits}")
    return "\n".join(lines)


def _scene_text(record: dict[str, Any]) -> str:
    lines = [_wrapped(f"{record['name']}: {record['description']}")]
    lines.append(_wrapped(f"obstacles: {', '.join(record['obstacles']) or 'none'}", 2))
    lines += [_wrapped(f"{robot}: {', '.join(states)}", 2) for robot, states in record["states"].items()]
    return "\n".join(lines)


def _wrapped(text: str, indent: int = 0) -> str:
    """The text in lines of at most ``WIDTH`` columns, cut between words only: what one has to type stays whole."""
    before = " " * indent
    return textwrap.fill(
        text,
        WIDTH,
        initial_indent=before,
        subsequent_indent=before + "  ",
        break_long_words=False,
        break_on_hyphens=False,
    )
