"""What is asked, made concrete: the robot as the scene sets it up, a checker, start and goal configurations."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import StateError, choices
from planner.base.request import RoadmapRequest, WorldRequest
from planner.base.targets import Joints, Target, parse_target
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.query.resolve import resolve
from planner.world.moveit import MotionPlanRequest, read_motion_plan_request
from planner.world.robot import Robot, robot_name, with_carried, with_tool, with_widened_limits
from planner.world.scene import Scene

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Query:
    """A robot in a scene with where it starts (k, dof) and where it may end (g, dof), rad."""

    robot: Robot
    scene: Scene
    checker: CollisionChecker
    starts: Floats
    goals: Floats


def open_world(request: WorldRequest, message: Path | None = None) -> CollisionChecker:
    """A checker of the robot in the scene that ``request`` names, with nowhere to go yet.

    Joints that are not planned are held as the MoveIt request in the file ``message`` has them.
    """
    scene = _scene(request)
    robot = _robot(request, scene, read_motion_plan_request(message) if message else None)
    _note_permissions(robot, scene)
    return make_checker(robot, scene, request.collision, request.margin)


def make_query(request: RoadmapRequest) -> Query:
    """Load everything that ``request`` names; raises :class:`PlannerError` for what is unusable."""
    scene = _scene(request)
    message = read_motion_plan_request(request.request) if request.request else None
    robot = _robot(request, scene, message)
    start, goals = _targets(request, robot, message)
    if request.widen_limits:
        robot = _widened(robot, [start, *goals])
    _note_permissions(robot, scene)
    checker = make_checker(robot, scene, request.collision, request.margin)
    states = scene.states_of(robot.name)
    starts = resolve(start, checker, states, "start")
    ends = [resolve(goal, checker, states, "goal", request.ik_solutions) for goal in goals]
    _, first = np.unique(np.vstack(ends), axis=0, return_index=True)  # one goal may be named twice
    return Query(robot, scene, checker, starts, np.vstack(ends)[np.sort(first)])


def _scene(request: WorldRequest) -> Scene:
    return request.scene if isinstance(request.scene, Scene) else Scene.load(str(request.scene))


def _robot(request: WorldRequest, scene: Scene, message: MotionPlanRequest | None) -> Robot:
    """The robot as the scene sets it up; one that is given as such stands as it is."""
    if isinstance(request.robot, Robot):
        return with_carried(with_tool(request.robot, request.tool), scene.carried)
    name = str(request.robot)
    placement = scene.placement(robot_name(name))
    tool, base = request.tool or placement.tool, placement.base.matrix()
    robot = Robot.load(name, tool, placement.fixed_joints, base)
    held = {} if message is None else {k: v for k, v in message.start.items() if k in robot.other_joints}
    if held:
        _log.info("joints that are not planned are held as the request has them: %s", held)
        robot = Robot.load(name, tool, {**placement.fixed_joints, **held}, base)
    return with_carried(robot, scene.carried)


def _targets(request: RoadmapRequest, robot: Robot, message: MotionPlanRequest | None) -> tuple[Target, list[Target]]:
    """Start and goals; an explicit --start or --goal goes before what the MoveIt request says."""
    plain = RoadmapRequest()
    start, goals = parse_target(str(request.start)), [parse_target(str(request.goal))]
    if message is not None and request.start == plain.start:
        start = _joints(robot, message.start, "start")
    if message is not None and request.goal == plain.goal:
        goals = [parse_target(g) if isinstance(g, str) else _joints(robot, g, "goal") for g in message.goals]
    return start, goals


def _joints(robot: Robot, values: dict[str, float], role: str) -> Joints:
    missing = [joint for joint in robot.joints if joint not in values]
    if missing:
        raise StateError(
            f"the request's {role} says nothing of {choices(missing)}: it is for another robot; choose --robot."
        )
    return Joints(tuple(values[joint] for joint in robot.joints))


def _widened(robot: Robot, targets: list[Target]) -> Robot:
    """Limits widened to what is asked for in joints; the log says which."""
    wanted = [np.array(t.values) for t in targets if isinstance(t, Joints) and len(t.values) == robot.dof]
    wanted = [q for q in wanted if np.isfinite(q).all()]
    if not wanted:
        return robot
    wide = with_widened_limits(robot, np.array(wanted))
    for k in np.nonzero((wide.lower < robot.lower) | (wide.upper > robot.upper))[0]:
        _log.warning("limits of %s widened to [%.4f, %.4f]", robot.joints[k], wide.lower[k], wide.upper[k])
    return wide


def _note_permissions(robot: Robot, scene: Scene) -> None:
    """A scene's matrix cannot allow two robot links to collide: only the robot's own SRDF can."""
    links = {body.link for body in robot.bodies}
    own = [pair for pair in scene.allowed if pair <= links and len(pair) == 2]
    ignored = sorted(" and ".join(sorted(pair)) for pair in own if pair not in (robot.disabled_pairs or frozenset()))
    if ignored:
        _log.info("the scene allows robot links to collide; they are checked all the same: %s", "; ".join(ignored))
