"""The text of a robot.yaml for a robot, with the reasons for its disabled pairs as comments."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

from planner.collision.self_pairs import ALWAYS, adjacent_pairs
from planner.models.files.packages import example_robot_data
from planner.models.files.robot_files import RobotFiles, Source
from planner.models.robot import Robot


def robot_yaml(files: RobotFiles, robot: Robot, never_apart: frozenset[frozenset[str]], folder: Path) -> str:
    """The text of a robot file for ``folder``: paths in it are relative to that.

    ``never_apart``: pairs of links that need no check because they are adjacent or touch nearly always.
    """
    return "\n".join([*_what(files, robot, folder), *_pairs(files, robot, never_apart)]) + "\n"


def _what(files: RobotFiles, robot: Robot, folder: Path) -> Iterator[str]:
    yield f"name: {json.dumps(robot.name)}"
    yield f"description: {json.dumps(_description(robot))}"
    own = files.file
    yield f"urdf: {_source(files.description.path, folder, own.urdf if own else None)}"
    if files.srdf is not None:
        yield f"srdf: {_source(files.srdf.path, folder, own.srdf if own else None)}"
    yield f"joints: {json.dumps(robot.joints)}"
    yield f"tool: {json.dumps(robot.tool)}"
    yield f"home: {json.dumps([float(value) for value in robot.home])}"
    yield f"manipulability: {robot.manipulability}"
    yield f"fixed_joints: {json.dumps(dict(robot.fixed_joints))}"
    if robot.motion is not None:
        yield f"motion: {json.dumps(robot.motion.model_dump(exclude_none=True), ensure_ascii=False)}"


def _description(robot: Robot) -> str:
    return robot.description if not robot.description.startswith("from ") else f"{robot.name}, {robot.dof} axes"


def _source(path: Path, folder: Path, own: Source | None) -> str:
    """A file as a robot file names it: within the package of robot data, or relative to ``folder``.

    With the arguments of a xacro file that the robot's ``own`` file has.
    """
    arguments = {"args": own.args} if own and own.args and Path(own.file).name == path.name else {}
    shipped = example_robot_data() / "robots"
    if path.resolve().is_relative_to(shipped):
        return json.dumps({"package": "example-robot-data", "file": path.resolve().relative_to(shipped).as_posix()})
    return json.dumps({"file": Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix(), **arguments})


def _pairs(files: RobotFiles, robot: Robot, never_apart: frozenset[frozenset[str]]) -> Iterator[str]:
    known = [sorted(pair) for pair in (files.file.disabled_pairs if files.file else None) or []]
    adjacent = adjacent_pairs(robot) & never_apart
    groups = {
        "as the robot file has them already": known,
        "joined by one joint": sorted(sorted(pair) for pair in adjacent),
        f"touch in at least {100 * ALWAYS:g} % of random configurations": sorted(map(sorted, never_apart - adjacent)),
    }
    yield "# link pairs that need no collision check, besides the SRDF's"
    yield "disabled_pairs:" if any(groups.values()) else "disabled_pairs: []"
    for reason, pairs in groups.items():
        if pairs:
            yield f"  # {reason}"
            yield from (f"  - {json.dumps(pair)}" for pair in pairs)
