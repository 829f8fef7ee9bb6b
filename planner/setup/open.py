"""From a request to the robot as the scene sets it up, a checker, and start and goal configurations."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import OptionError, SceneError, choices
from planner.base.places import Place
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.models.files.robot_files import JointChoice, read_robot
from planner.models.model_checks import require_bodies, tell
from planner.models.poses import pose
from planner.models.robot import Robot, assemble, with_carried, with_tool, with_widened_limits
from planner.models.scene import Scene
from planner.problem.request import RoadmapRequest, WorldRequest
from planner.problem.targets import HOME, Joints, Target, joints_text, parse_base, parse_target, parse_targets
from planner.setup.message import asked_of, choice_of, goals_of, in_request, joints_of, start_of, unasked
from planner.setup.resolve import looks_like_degrees, resolve

if TYPE_CHECKING:
    from planner.models.files.moveit.requests import MotionPlanRequest

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Query:
    """A robot in a scene with where it starts (k, dof) and where it may end (g, dof), rad.

    ``goal_names`` (g,) is the text of the goal that each row of ``goals`` reaches.
    """

    robot: Robot
    scene: Scene
    checker: CollisionChecker
    starts: Floats
    goals: Floats
    goal_names: tuple[str, ...]

    def goal_at(self, q: Floats) -> str:
        """The text of the goal that the configuration ``q`` (dof,) reaches, of all the nearest one."""
        away = np.abs(self.robot.difference(self.goals, q)).max(axis=1)
        return self.goal_names[int(away.argmin())]


def open_world(request: WorldRequest, message: Place | None = None) -> CollisionChecker:
    """A checker of the robot in the scene that ``request`` names, without start and goal.

    Joints that are not planned are held as the MoveIt request in the file ``message`` has them.
    """
    scene, robot = _set_up(request, _message(message))
    _judge(robot, scene)
    return make_checker(robot, scene, request.collision, request.margin)


def make_query(request: RoadmapRequest, near_start: bool = True, in_time: bool = False) -> Query:
    """Load everything that ``request`` names; raises :class:`PlannerError` for what is unusable.

    The configurations that a position or pose as goal becomes are chosen by their manipulability and by how near they
    are to the start; by manipulability alone without ``near_start``. A scene in which obstacles move along known
    motions is refused, but where the answer has times (``in_time``).
    """
    message = _message(request.motion_plan_request)
    scene, robot = _set_up(request, message)
    if scene.moving and not in_time:
        raise SceneError(
            f"in scene '{scene.name}' obstacles move ({choices(item.name for item in scene.moving)}), and a path "
            "without times cannot keep clear of them: plan in time, by 'planner plan' without --no-timing, or by "
            "Session.plan_in_time."
        )
    start, goals = _targets(request, robot, scene, message)
    if request.widen_limits:
        robot = _widened(robot, [start, *(goal for _, goal in goals)])
    _judge(robot, scene)
    checker = make_checker(robot, scene, request.collision, request.margin)
    return resolve_query(checker, start, goals, request.ik_solutions, near_start)


def resolve_query(
    checker: CollisionChecker,
    start: Target,
    goals: list[tuple[str, Target]],
    ik_solutions: int,
    near_start: bool = True,
) -> Query:
    """The configurations of a start and of goals with their texts; raises :class:`StateError` for unusable ones.

    ``near_start`` as in :func:`make_query`.
    """
    robot, scene = checker.robot, checker.world.scene
    states = states_of(robot, scene)
    starts = resolve(start, checker, states, "start")
    ends, names = [], []
    for name, goal in goals:
        role = "goal" if len(goals) == 1 else f"goal '{name}'"
        ends.append(resolve(goal, checker, states, role, ik_solutions, starts if near_start else None))
        names += [name] * len(ends[-1])
    _, rows = np.unique(np.vstack(ends), axis=0, return_index=True)  # one goal may be named twice
    rows.sort()
    return Query(robot, scene, checker, starts, np.vstack(ends)[rows], tuple(names[row] for row in rows))


def _message(path: Place | None) -> MotionPlanRequest | None:
    if path is None:
        return None
    from planner.models.files.moveit.requests import read_motion_plan_request

    return read_motion_plan_request(path)


def _set_up(request: WorldRequest, message: MotionPlanRequest | None) -> tuple[Scene, Robot]:
    """The scene, and the robot in it, as a MoveIt request changes them: every command loads its robot here."""
    scene = request.scene if isinstance(request.scene, Scene) else Scene.load(str(request.scene))
    scene = unasked(scene) if message is None else in_request(scene, message)
    return scene, _robot(request, scene, message)


def _robot(request: WorldRequest, scene: Scene, message: MotionPlanRequest | None) -> Robot:
    """The robot as the scene and the request set it up; one that is given as such stands as it is."""
    if isinstance(request.robot, Robot):
        _require_as_it_is(request)
        return asked_of(with_carried(with_tool(request.robot, request.tool), scene.carried), message)
    files = read_robot(str(request.robot), request.srdf)
    placement = scene.placement(files.name)
    tool, fixed = request.tool or placement.tool, dict(placement.fixed_joints)
    choice = JointChoice(request.group, request.joint_names)
    if message is not None:
        choice, start = choice_of(message, choice, files), start_of(message, scene)
        planned = files.planned_joints(tool, choice, fixed)
        held = {name: start[name] for name in files.model.names[1:] if name in start and name not in planned}
        _log.info("joints that are not planned are held as the request has them: %s", held or "it names none")
        fixed |= held
    base = placement.base.matrix() if request.base is None else pose(*parse_base(request.base))
    return asked_of(with_carried(assemble(files, tool, choice, fixed, base), scene.carried), message, choice)


def _require_as_it_is(request: WorldRequest) -> None:
    for option in ("srdf", "group", "joints", "base"):
        if getattr(request, option) is not None:
            raise OptionError(
                f"'{option}' is for a robot given by name or path: give it to Robot.load, which made this one."
            )


def states_of(robot: Robot, scene: Scene) -> dict[str, str]:
    """The named states of a robot, each as its text: those of its SRDF, and of the scene, which come first."""
    own = {name: joints_text(values) for name, values in robot.states.items() if name != HOME}
    return {**own, **scene.states_of(robot.name)}


def _targets(
    request: RoadmapRequest, robot: Robot, scene: Scene, message: MotionPlanRequest | None
) -> tuple[Target, list[tuple[str, Target]]]:
    """Start, and goals with their texts; an explicit --start or --goal takes precedence over the MoveIt request."""
    plain = RoadmapRequest()
    start, goals = parse_target(str(request.start)), parse_targets(str(request.goal))
    if message is not None and request.start == plain.start:
        start = joints_of(message, robot, scene)
    if message is not None and request.goal == plain.goal:
        goals = goals_of(message, robot, scene)
    return start, goals


def _widened(robot: Robot, targets: list[Target]) -> Robot:
    """Limits widened to what is asked for in joints, unless that looks like degrees; the log says which."""
    wanted = [np.array(t.values) for t in targets if isinstance(t, Joints) and len(t.values) == robot.dof]
    wanted = [q for q in wanted if np.isfinite(q).all() and not looks_like_degrees(robot, q)]
    if not wanted:
        return robot
    wide = with_widened_limits(robot, np.array(wanted))
    for k in np.nonzero((wide.lower < robot.lower) | (wide.upper > robot.upper))[0]:
        _log.warning("limits of %s widened to [%.4f, %.4f]", robot.joints[k], wide.lower[k], wide.upper[k])
    return wide


def _judge(robot: Robot, scene: Scene) -> None:
    require_bodies(robot)
    tell(robot, scene)
