"""Where the arm should be, as people write it, and the configuration that takes it there.

A state is a name from the scene, ``q:0.1,-0.4,...`` (joints, rad), ``xyz:0.92,-0.10,0.42`` (tool position, m) or
``pose:x,y,z,qx,qy,qz,qw`` (tool position and orientation).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import pinocchio as pin

from planner.arrays import Floats, frozen
from planner.collision.checker import CollisionChecker, contact_of
from planner.collision.world import Contact
from planner.errors import OptionError, StateError, choices
from planner.kinematics import inverse
from planner.kinematics.manipulability import manipulability
from planner.poses import pose, se3
from planner.robot import Robot

IK_STARTS = 100
IK_SEED = 0  # its own, so that the same target gives the same configuration whatever --seed says


@dataclass(frozen=True, eq=False)
class Joints:
    """Joint values (dof,), rad."""

    values: Floats


@dataclass(frozen=True, eq=False)
class Position:
    """A place for the tool's origin (3,), m; its orientation is free."""

    xyz: Floats


@dataclass(frozen=True, eq=False)
class Pose:
    """A placement (4, 4) of the tool frame."""

    matrix: Floats


@dataclass(frozen=True)
class Named:
    """A state that the scene names."""

    name: str


Target: TypeAlias = Joints | Position | Pose | Named

_FORMS = "a name from the scene, q:..., xyz:x,y,z or pose:x,y,z,qx,qy,qz,qw"


def parse_target(text: str) -> Target:
    """A target out of its text; :class:`OptionError` where the text has no meaning. NaN is left to :func:`resolve`."""
    kind, colon, rest = text.partition(":")
    if not colon:
        if not text.strip():
            raise OptionError(f"an empty state is not usable: give {_FORMS}.")
        return Named(text.strip())
    counts = {"q": None, "xyz": 3, "pose": 7}
    if kind not in counts:
        raise OptionError(f"state '{text}' starts with '{kind}:': give {_FORMS}.")
    try:
        values = np.array([float(part) for part in rest.split(",")])
    except ValueError:
        raise OptionError(f"state '{text}' holds something that is no number: give numbers with commas between.") from None
    wanted = counts[kind]
    if wanted is not None and len(values) != wanted:
        raise OptionError(f"state '{text}' has {len(values)} numbers, '{kind}:' takes {wanted}.")
    if kind == "q":
        return Joints(frozen(values))
    if kind == "xyz":
        return Position(frozen(values))
    return _pose(text, values)


def _pose(text: str, values: Floats) -> Target:
    if not np.isfinite(values).all():
        return Position(frozen(values[:3] + values[3:].sum()))  # refused by resolve, which says which state it was
    try:
        return Pose(pose(values[:3], quaternion=values[3:]))
    except ValueError as error:
        raise OptionError(f"state '{text}': {error}; give a unit quaternion qx,qy,qz,qw.") from None


def resolve(
    target: Target, checker: CollisionChecker, states: Mapping[str, str], role: str, count: int = 1
) -> Floats:
    """Up to ``count`` collision-free configurations (k, dof) that reach ``target``, best manipulability first.

    ``states`` are the scene's named states of this robot, ``role`` is "start" or "goal" for the messages. Inverse
    kinematics starts from ``IK_STARTS`` seeds; of the solutions that are free and within limits the ones with the
    highest manipulability are kept. Raises :class:`StateError`: out of limits, in collision, out of reach.
    """
    match target:
        case Named(name):
            if name not in states:
                raise StateError(
                    f"{role} '{name}' is not among the scene's states for {checker.world.robot.name} "
                    f"({choices(states)}): give one of them, or {_FORMS}."
                )
            inner = parse_target(states[name])
            if isinstance(inner, Named):
                raise StateError(f"state '{name}' of the scene names another state '{inner.name}': give numbers.")
            return resolve(inner, checker, states, role, count)
        case Joints(values):
            return _check_joints(values, checker, role)
        case Position(xyz):
            _check_finite(xyz, role)
            rng = np.random.default_rng(IK_SEED)
            solutions = inverse.solve_position(checker.world.robot, xyz, rng, IK_STARTS)
            return _choose(solutions, checker, xyz, role, count)
        case Pose(matrix):
            rng = np.random.default_rng(IK_SEED)
            solutions = inverse.solve_pose(checker.world.robot, se3(matrix), rng, IK_STARTS)
            return _choose(solutions, checker, matrix[:3, 3], role, count)


def _check_finite(values: Floats, role: str) -> None:
    if not np.isfinite(values).all():
        raise StateError(f"{role} holds a value that is not finite: give plain numbers.")


def _check_joints(values: Floats, checker: CollisionChecker, role: str) -> Floats:
    robot = checker.world.robot
    if len(values) != robot.dof:
        raise StateError(
            f"{role} has {len(values)} joint values, {robot.name} has {robot.dof} planned joints: {choices(robot.joints)}."
        )
    _check_finite(values, role)
    check_limits(robot, values, role)
    contact = contact_of(checker, values)
    if contact is not None:
        raise StateError(f"{role} is in collision: {_describe(contact, checker)}; move it or the obstacle.")
    return frozen(robot.normalise(values)[None])


def check_limits(robot: Robot, values: Floats, role: str) -> None:
    """Raise :class:`StateError` naming the first joint that is out of its limits and by how much."""
    below, above = robot.lower - values, values - robot.upper
    beyond = np.where(robot.continuous, 0.0, np.maximum(below, above))
    # 1e-9 forgives a limit that was printed and read back
    for k in np.nonzero(beyond > 1e-9)[0]:
        raise StateError(
            f"{role} puts joint '{robot.joints[k]}' at {values[k]:.6g}, outside its limits "
            f"[{robot.lower[k]:.6g}, {robot.upper[k]:.6g}] by {beyond[k]:.3g} rad: bring it inside."
        )


def _choose(
    solutions: inverse.Solutions, checker: CollisionChecker, position: Floats, role: str, count: int
) -> Floats:
    found = solutions.configurations
    if not len(found):
        raise StateError(_out_of_reach(solutions, checker.world.robot, position, role))
    contacts = [contact_of(checker, q) for q in found]
    free = np.array([contact is None for contact in contacts])
    if not free.any():
        first = next(contact for contact in contacts if contact is not None)
        raise StateError(
            f"{role} is reached by {len(found)} configurations, all in collision (the first: "
            f"{_describe(first, checker)}); move it or the obstacle."
        )
    candidates = found[free]
    order = np.argsort(-manipulability(checker.world.robot, candidates), kind="stable")
    return frozen(candidates[order[:count]])


def _describe(contact: Contact, checker: CollisionChecker) -> str:
    margin = checker.world.margin
    return f"{contact} are closer than the margin of {margin:g} m" if margin else f"{contact} touch"


def _out_of_reach(solutions: inverse.Solutions, robot: Robot, position: Floats, role: str) -> str:
    place = ", ".join(f"{value:g}" for value in position)
    beyond = inverse.beyond_reach(robot, position)
    reach = f"the target lies {beyond:.3f} m beyond the arm's reach" if beyond > 0 else "joint limits or orientation forbid it"
    turn = f" and {np.degrees(solutions.angle):.2f} degrees" if solutions.angle > inverse.ANGLE_TOLERANCE else ""
    return (
        f"{role} ({place}) cannot be reached by frame '{robot.tool}': the nearest configuration of {IK_STARTS} tries "
        f"stays {solutions.distance:.4f} m{turn} away ({reach}); choose a nearer one."
    )


