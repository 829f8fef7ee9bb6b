"""Configurations that bring tools to positions and poses, by inverse kinematics."""

from collections.abc import Sequence

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import StateError, choices, format_quantity
from planner.base.yamlfile import FARTHEST
from planner.collision.checker import CollisionChecker
from planner.kinematics import inverse
from planner.problem.options import IK_LARGEST, IK_LEAST
from planner.problem.outcome import OutOfReach
from planner.problem.targets import Pose, Position, ToolGoal
from planner.robot.poses import pose, se3
from planner.robot.robot import Robot, with_tool

IK_STARTS = 100
IK_SEED = 0  # apart from --seed: a target always gives the same configuration
_AROUND = 15  # seeds around each start: the nearest solution may be blocked
_SPREAD = 0.4  # rad (m), of these seeds


def targets_of_several_tools(target: ToolGoal, checker: CollisionChecker) -> tuple[Position | Pose, ...]:
    """Return the positions and poses of several frames that make up a goal, none if it is another one."""
    exact = () if checker.world.constraints else target.exact
    return exact if len(exact) > 1 else ()


def reach_targets(
    targets: Sequence[Position | Pose],
    robot: Robot,
    role: str,
    starts: Floats | None,
    tolerance: inverse.Tolerance,
) -> Floats:
    """Return configurations (k, dof) that reach all targets; :class:`StateError` if there are none."""
    robot = with_tool(robot, ",".join(target.frame or robot.tool for target in targets))
    near = None if starts is None else seeds_around(robot, starts)
    places = [_placement(target, role) for target in targets]
    rng, tries = np.random.default_rng(IK_SEED), len(targets) * IK_STARTS
    solutions = inverse.solve(robot, places, rng, tries, near, tolerance)
    if len(solutions.configurations):
        return solutions.configurations
    if len(targets) == 1:
        raise _out_of_reach(solutions, robot, targets[0], role)
    for target in targets:  # one that is out of reach by itself explains more
        reach_targets((target,), robot, role, starts, tolerance)
    raise StateError(
        f"{role} cannot be reached by frames {choices(robot.tools)} at once, only by each of them: the nearest "
        f"configuration of {tries} tries has one {format_quantity(solutions.distance, 'm')} and "
        f"{format_quantity(solutions.angle, 'rad')} away; bring the targets closer together.",
        OutOfReach(role, solutions.distance),
    )


def _placement(target: Position | Pose, role: str) -> inverse.Target:
    if isinstance(target, Position):
        require_finite(np.array(target.xyz), role)
        return np.array(target.xyz)
    require_finite(np.array([*target.xyz, *target.quaternion]), role)
    try:
        return se3(pose(target.xyz, quaternion=target.quaternion))
    except ValueError as error:
        raise StateError(f"{role}: {error}; give a unit quaternion qx,qy,qz,qw.") from None


def seeds_around(robot: Robot, starts: Floats) -> Floats:
    """Return seeds (k, dof) of inverse kinematics: ``starts`` (s, dof) and configurations around them."""
    noise = np.random.default_rng(IK_SEED).normal(scale=_SPREAD, size=(_AROUND, *starts.shape))
    around = np.where(robot.continuous, starts + noise, np.clip(starts + noise, robot.lower, robot.upper))
    return np.vstack([starts, around.reshape(-1, robot.dof)])


def require_finite(values: Floats, role: str) -> None:
    if len(wrong := values[~(np.abs(values) <= FARTHEST)]):
        raise StateError(
            f"{role} must hold finite numbers of at most {FARTHEST:g}, got {wrong[0]:g}: give them in rad and metres."
        )


def _out_of_reach(solutions: inverse.Solutions, robot: Robot, target: Position | Pose, role: str) -> StateError:
    place = ", ".join(f"{value:g}" for value in target.xyz)
    reach = "joint limits or orientation forbid it"
    if (beyond := inverse.beyond_reach(robot, np.array(target.xyz))) > 0:
        reach = f"the target lies {format_quantity(beyond, 'm')} beyond the arm's reach"
    distance, angle, remedy = solutions.distance, solutions.angle, "choose a nearer one"
    if isinstance(target, Pose) and distance <= IK_LARGEST[0] / 2 and angle <= IK_LARGEST[1] / 2:
        allowed = ",".join(f"{max(1.1 * miss, IK_LEAST):.2g}" for miss in (distance, angle))
        remedy += f", or allow as much by --ik-tolerance {allowed}"
    turn = f" and {format_quantity(angle, 'rad')}" if isinstance(target, Pose) else ""
    return StateError(
        f"{role} ({place}) cannot be reached by frame '{robot.tool}': the nearest configuration of {IK_STARTS} tries "
        f"stays {format_quantity(distance, 'm')}{turn} away ({reach}); {remedy}.",
        OutOfReach(role, float(distance)),
    )
