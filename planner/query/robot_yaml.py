"""The text of a robot.yaml for a robot, with the reasons for its disabled pairs as comments."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from planner.collision.self_pairs import ALWAYS, adjacent_pairs
from planner.robot.files.packages import example_robot_data
from planner.robot.files.robot_files import RobotFiles, Source
from planner.robot.robot import Robot


def robot_yaml(files: RobotFiles, robot: Robot, never_apart: frozenset[frozenset[str]], folder: Path) -> str:
    """The text of a robot file for ``folder``: paths in it are relative to that.

    ``never_apart``: pairs of links that need no check because they are adjacent or touch nearly always.
    """
    own, text = files.file, robot.description
    values = {
        "name": robot.name,
        "description": f"{robot.name}, {robot.dof} axes" if text.startswith("from ") else text,
        "urdf": _source(files.description.path, folder, own and own.urdf),
        "srdf": files.srdf and _source(files.srdf.path, folder, own and own.srdf),
        "joints": robot.joints,
        "tool": robot.tool,
        "home": robot.home.tolist(),
        "manipulability": robot.manipulability,
        "fixed_joints": dict(robot.fixed_joints),
    }
    adjacent = adjacent_pairs(robot) & never_apart
    groups = {
        "as the robot file has them already": (own and own.disabled_pairs) or [],
        "joined by one joint": adjacent,
        f"touch in at least {100 * ALWAYS:g} % of random configurations": never_apart - adjacent,
    }
    lines = [f"{key}: {json.dumps(value)}" for key, value in values.items() if value is not None]
    if robot.motion is not None:
        lines.append(f"motion: {json.dumps(robot.motion.model_dump(exclude_none=True), ensure_ascii=False)}")
    lines.append("# link pairs that need no collision check, besides the SRDF's")
    lines.append("disabled_pairs:" if any(groups.values()) else "disabled_pairs: []")
    for reason, pairs in groups.items():
        lines += [f"  # {reason}"] * bool(pairs) + [f"  - {json.dumps(pair)}" for pair in sorted(map(sorted, pairs))]
    return "\n".join(lines) + "\n"


def _source(path: Path, folder: Path, own: Source | None) -> dict[str, Any]:
    """A file as a robot file names it: within the package of robot data, or relative to ``folder``.

    With the arguments of a xacro file that the robot's ``own`` file has.
    """
    path, shipped = path.resolve(), example_robot_data() / "robots"
    if path.is_relative_to(shipped):
        return {"package": "example-robot-data", "file": path.relative_to(shipped).as_posix()}
    arguments = {"args": own.args} if own and own.args and Path(own.file).name == path.name else {}
    return {"file": Path(os.path.relpath(path, folder.resolve())).as_posix(), **arguments}
