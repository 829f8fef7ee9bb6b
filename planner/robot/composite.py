"""One robot of several: joints, links and frames get the prefix of their part, all else stays.

Pairs of links of different parts are checked like all others, so proofs of the composite cover contacts between robots.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats, frozen
from planner.base.errors import RobotError
from planner.base.yamlfile import find_duplicates, quote
from planner.kinematics.arm import Mimic
from planner.robot.files.urdf import Description
from planner.robot.poses import pose
from planner.robot.robot import Robot, part_bodies


def combine_robots(name: str, parts: Mapping[str, Robot]) -> Robot:
    """Return the robot of ``parts`` by prefix; its configurations are theirs one after the other.

    Its tools are those of all parts with the same rows of the Jacobian as the first, so w is the least of theirs.
    Raises :class:`RobotError` for names that two parts share. Payload is attached to the composite.
    """
    if twice := find_duplicates(prefix + name for prefix, robot in parts.items() for name in _names(robot)):
        raise RobotError(
            f"prefixes must keep names apart, got {quote(twice[0])} twice: give each robot its own prefix."
        )
    robots = list(parts.values())
    first, model = robots[0], pin.Model()
    for prefix, robot in parts.items():
        model = pin.appendModel(model, _with_prefix(robot.model, prefix), 0, pin.SE3.Identity())
    model.name = name
    disabled = [
        None if robot.disabled_pairs is None else prefix_pairs(prefix, robot.disabled_pairs)
        for prefix, robot in parts.items()
    ]
    pairs = [each for each in disabled if each is not None]

    alike = [(prefix, robot) for prefix, robot in parts.items() if robot.jacobian_rows == first.jacobian_rows]
    tools = tuple(prefix + tool for prefix, robot in alike for tool in robot.tools)

    def rows(field: str) -> Floats:
        return frozen(np.concatenate([getattr(robot, field) for robot in robots]))

    return Robot(
        name=name,
        description=", ".join(f"{prefix}: {robot.description}" for prefix, robot in parts.items()),
        joints=tuple(prefix + joint for prefix, robot in parts.items() for joint in robot.joints),
        lower=rows("lower"),
        upper=rows("upper"),
        velocity=rows("velocity"),
        continuous=frozen(np.concatenate([robot.continuous for robot in robots]), np.bool_),
        tool=tools[0],
        other_tools=tools[1:],
        home=rows("home"),
        jacobian_rows=first.jacobian_rows,
        measure=first.measure,
        disabled_pairs=frozenset().union(*pairs) if len(pairs) == len(parts) else None,
        base=frozen(pose()),
        source=_describe(name, parts),
        notes=tuple(replace(note, text=f"{p}: {note.text}") for p, robot in parts.items() for note in robot.notes),
        model=model,
        bodies=part_bodies(parts, [robot.bodies for robot in robots]),
        fixed_joints={
            prefix + joint: at for prefix, robot in parts.items() for joint, at in robot.fixed_joints.items()
        },
        followers=tuple(
            Mimic(prefix + item.joint, prefix + item.leader, item.multiplier, item.offset)
            for prefix, robot in parts.items()
            for item in robot.followers
        ),
        parts=dict(parts),
    )


def prefix_pairs(prefix: str, pairs: Iterable[frozenset[str]]) -> frozenset[frozenset[str]]:
    """Return pairs of links by their names in the composite."""
    return frozenset(frozenset(prefix + link for link in pair) for pair in pairs)


def _names(robot: Robot) -> set[str]:
    """Return the names of joints and frames, as those of different parts must differ."""
    return {*robot.model.names[1:], *(frame.name for frame in list(robot.model.frames)[1:])}


def _with_prefix(model: pin.Model, prefix: str) -> pin.Model:
    """Return the model with the prefix before all names but the universe's."""
    own = model.copy()
    for joint in range(1, own.njoints):
        own.names[joint] = prefix + own.names[joint]
    for k in range(1, own.nframes):
        own.frames[k].name = prefix + own.frames[k].name
    return own


def _describe(name: str, parts: Mapping[str, Robot]) -> Description:
    """Return the links and joints of the parts; bodies and pictures come from the parts themselves."""
    sources = {prefix: robot.source for prefix, robot in parts.items()}
    return Description(
        path=Path(name),
        name=name,
        xml="<robot/>",
        continuous=frozenset(prefix + joint for prefix, source in sources.items() for joint in source.continuous),
        collision_elements=sum(source.collision_elements for source in sources.values()),
        bare=frozenset(prefix + link for prefix, source in sources.items() for link in source.bare),
        links=frozenset(prefix + link for prefix, source in sources.items() for link in source.links),
        joints={
            prefix + joint: (prefix + above, prefix + below)
            for prefix, source in sources.items()
            for joint, (above, below) in source.joints.items()
        },
    )
