"""The text of a robot.yaml, and a self-test of a robot: home, tool positions, links that touch."""

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.errors import StateError
from planner.base.files import StrPath, make_folder, write_whole
from planner.collision.checker import CollisionChecker
from planner.collision.coal import CoalChecker
from planner.collision.self_pairs import ALWAYS, adjacent_pairs, generate_disabled_pairs
from planner.collision.world import World
from planner.kinematics.forward import tool_positions
from planner.problem.targets import Position
from planner.query.resolve import resolve
from planner.query.robots import at_usable_home, touching_pairs
from planner.robot.files.packages import example_robot_data
from planner.robot.files.robot_files import JointChoice, RobotFiles, Source, read_robot
from planner.robot.robot import Robot, assemble
from planner.robot.robot_in_scene import require_bodies
from planner.robot.scene import Scene

_SAMPLES, _TARGETS = 200, 8
_OFTEN = 0.5  # share of random configurations from which on a pair that touches is named


def write_robot_yaml(
    name: str, srdf: StrPath | None, tool: str | None, choice: JointChoice, out: Path
) -> Iterator[str]:
    """Write a robot file for a robot by name or path, and yield sentences on it, of :func:`self_test` too."""
    files = read_robot(name, srdf)
    assembled = assemble(files, tool, choice)
    require_bodies(assembled)
    robot = at_usable_home(files, assembled)
    yield from (note.text for note in robot.notes[len(assembled.notes) :])
    listed = robot.disabled_pairs or frozenset()
    pairs = generate_disabled_pairs(robot, CoalChecker) - listed
    checker = CoalChecker(World.from_scene(robot, Scene("none"), pairs | listed))
    make_folder(out.parent)
    write_whole(out, robot_yaml(files, robot, pairs, out.parent).encode())
    yield from self_test(checker)
    yield f"Written: {out}, with {len(pairs)} pairs of links that need no check. Plan with --robot {out}"


def robot_yaml(files: RobotFiles, robot: Robot, never_apart: frozenset[frozenset[str]], folder: Path) -> str:
    """The text of a robot file for ``folder``: paths in it are relative to that.

    ``never_apart``: pairs of links that need no check because they are adjacent or touch nearly always.
    """
    own, text = files.file, robot.description
    values = {
        "name": robot.name,
        "description": f"{robot.name}, {robot.dof} axes" if text.startswith("from ") else text,
        "urdf": _source(files.description.path, folder, own.urdf),
        "srdf": files.srdf and _source(files.srdf.path, folder, own.srdf),
        "joints": robot.joints,
        "tool": robot.tool_text,
        "home": robot.home.tolist(),
        "manipulability": robot.jacobian_rows,
        "fixed_joints": dict(robot.fixed_joints),
        "mesh_pieces": own.mesh_pieces or None,
        "motion": robot.motion and robot.motion.model_dump(exclude_none=True),
    }
    adjacent = adjacent_pairs(robot) & never_apart
    groups = {
        "as the robot file has them already": own.disabled_pairs or [],
        "joined by one joint": adjacent,
        f"touch in at least {100 * ALWAYS:g} % of random configurations": never_apart - adjacent,
    }
    lines = [f"{key}: {json.dumps(value, ensure_ascii=False)}" for key, value in values.items() if value is not None]
    lines.append("# link pairs that need no collision check, besides the SRDF's")
    lines.append("disabled_pairs:" if any(groups.values()) else "disabled_pairs: []")
    for reason, pairs in groups.items():
        lines += [f"  # {reason}"] * bool(pairs) + [f"  - {json.dumps(pair)}" for pair in sorted(map(sorted, pairs))]
    return "\n".join(lines) + "\n"


def _source(path: Path, folder: Path, own: Source | None) -> dict[str, Any]:
    """A file as a robot file names it, with the arguments that the robot's ``own`` file gives it."""
    path, shipped = path.resolve(), example_robot_data() / "robots"
    if path.is_relative_to(shipped):
        return {"package": "example-robot-data", "file": path.relative_to(shipped).as_posix()}
    arguments = {"args": own.args} if own and own.args and Path(own.file).name == path.name else {}
    return {"file": Path(os.path.relpath(path, folder.resolve())).as_posix(), **arguments}


def self_test(checker: CollisionChecker) -> Iterator[str]:
    """Yield sentences on the robot of ``checker``: home, reach, and pairs of links that touch too often."""
    robot = checker.robot
    random = np.random.default_rng(0).uniform(robot.lower, robot.upper, size=(_SAMPLES, robot.dof))
    at_home, touching = touching_pairs(checker, robot.home[None])[0], touching_pairs(checker, random)
    reached = sum(_is_reached(checker, xyz) for xyz in tool_positions(robot, random[:_TARGETS]).tolist())
    yield (
        f"Test without obstacles: home is {'in collision' if at_home.any() else 'free'}, {reached} of {_TARGETS} tool "
        f"positions are reached, {100 * (~touching.any(axis=1)).mean():.0f} % of random configurations are free."
    )
    shares, places = touching.mean(axis=0), dict[tuple[str, ...], str]()
    for pair in np.flatnonzero(at_home | (shares >= _OFTEN)).tolist():
        contact = checker.world.contact(pair)
        often = f"in {100 * shares[pair]:.0f} % of random configurations" if shares[pair] >= _OFTEN else ""
        where = " and ".join(filter(None, ("at home" if at_home[pair] else "", often)))
        places[tuple(sorted((contact.first, contact.second)))] = where
    for (first, second), where in sorted(places.items()):
        yield (
            f"'{first}' and '{second}' touch {where}: if the real ones do not, give the URDF simpler collision "
            f'geometry there, or add ["{first}", "{second}"] to disabled_pairs of the file.'
        )


def _is_reached(checker: CollisionChecker, xyz: tuple[float, float, float]) -> bool:
    try:
        resolve(Position(tuple(xyz)), checker, {}, "goal")
    except StateError:
        return False
    return True
