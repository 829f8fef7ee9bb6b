"""The text of a robot.yaml for a URDF and SRDF, with the reasons for its disabled pairs as comments."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

from planner.collision.pair_survey import Reason, Survey
from planner.models.files.packages import example_robot_data
from planner.models.files.robot_files import RobotFiles, Source
from planner.models.robot import Robot

_DISABLED = (Reason.ADJACENT, Reason.ALWAYS, Reason.APART)


def robot_yaml(files: RobotFiles, robot: Robot, survey: Survey, folder: Path, trust_samples: bool = False) -> str:
    """The text of a robot file that stands in ``folder``: paths in it are relative to that.

    Pairs that were only never seen to touch stand there as comments, with ``trust_samples`` as disabled pairs.
    """
    return "\n".join([*_what(files, robot, folder), *_pairs(files, survey, trust_samples)]) + "\n"


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


def _pairs(files: RobotFiles, survey: Survey, trust_samples: bool) -> Iterator[str]:
    yield f"# link pairs that need no check, besides the SRDF's; found by {survey.samples} random configurations"
    listed = [reason for reason in _DISABLED if survey.pairs(reason)]
    never = survey.pairs(Reason.NEVER)
    known = (files.file.disabled_pairs if files.file else None) or []
    yield "disabled_pairs:" if known or listed or (never and trust_samples) else "disabled_pairs: []"
    if known:
        yield "  # as the robot file has them already"
        yield from (f"  - {json.dumps(pair)}" for pair in known)
    for reason in listed:
        yield f"  # {reason.value}"
        yield from (f"  - {json.dumps(pair)}" for pair in survey.pairs(reason))
    if never:
        yield f"  # {Reason.NEVER.value}" + ("" if trust_samples else ": they are checked")
        yield from (f"  {'' if trust_samples else '# '}- {json.dumps(pair)}" for pair in never)
