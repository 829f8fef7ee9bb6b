"""From a request to the robot in its scene, a checker, and start and goal configurations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import SceneError, choices, log_notes
from planner.base.files import StrPath
from planner.base.progress import QUIET, Progress
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker, with_conditions
from planner.constraints.path_constraints import bind_to_start, relative_to_start
from planner.kinematics.inverse import Tolerance
from planner.problem.conditions import Condition, parse_constraints
from planner.problem.request import ProblemRequest, WorldRequest
from planner.problem.targets import HOME, Joints, Target, joints_text
from planner.query.cells import composite_targets
from planner.query.resolve import check_limits, joint_values, other_turns, resolve
from planner.query.robots import load_cell, open_cell, robot_of, widen_limits_for
from planner.robot import robot_in_scene
from planner.robot.moveit.requests import (
    MotionPlanRequest,
    goal_targets,
    path_conditions,
    read_motion_plan_request,
    start_joints,
    with_path_limits,
    with_start_state,
)
from planner.robot.robot import Robot
from planner.robot.scene import Scene


@dataclass(frozen=True, eq=False)
class Query:
    """A robot in a scene with ``starts`` (k, dof) and ``goals`` (g, dof), rad.

    ``goal_names`` (g,) is the text of the goal that each row of ``goals`` reaches; ``end_notes`` are on the start.
    """

    robot: Robot
    scene: Scene
    checker: CollisionChecker
    starts: Floats
    goals: Floats
    goal_names: tuple[str, ...]
    end_notes: tuple[str, ...] = ()

    @property
    def ends(self) -> Floats:
        """Starts, then goals (k + g, dof)."""
        return np.concatenate([self.starts, self.goals])

    def goal_at(self, q: Floats) -> str:
        """Return the text of the goal nearest to the configuration ``q`` (dof,)."""
        away = np.abs(self.robot.difference(self.goals, q)).max(axis=1)
        return self.goal_names[int(away.argmin())]

    def with_texts(self, goals: Sequence[Target]) -> Query:
        """Return the query of a cell with the texts of its ``goals``, the first one for joined goals."""
        texts = [goal.text for goal in goals]
        return replace(self, goal_names=tuple(name if name in texts else texts[0] for name in self.goal_names))


def make_checker_for(
    request: WorldRequest, message: StrPath | None = None, start: Callable[[CollisionChecker], Floats] | None = None
) -> CollisionChecker:
    """Return a checker of the robot in the scene of ``request``, without start and goal.

    Joints that are not planned are held at their values in the MoveIt request ``message``. ``start`` returns the
    configuration (dof,) whose orientation completes orientation constraints without a quaternion.
    """
    asked = None if message is None else read_motion_plan_request(message)
    scene, robot = _set_up(request, asked)
    robot, constraint = _collect_constraints(request, robot, scene, asked)
    _judge(request, robot, scene)
    turns = relative_to_start(constraint) if start is not None else ()
    rest = [each for each in constraint if each not in turns]
    checker = make_checker(robot, scene, request.collision, request.margin, rest)
    return _bound(checker, turns, start(checker)) if start is not None and turns else checker


def _bound(checker: CollisionChecker, turns: tuple[Condition, ...], start: Floats) -> CollisionChecker:
    """Return the checker with ``turns`` too, relative to the orientation at ``start`` (dof,)."""
    return with_conditions(checker, (*checker.world.conditions, *bind_to_start(turns, checker.robot, start)))


def make_query(
    request: ProblemRequest, near_start: bool = True, in_time: bool = False, progress: Progress = QUIET
) -> Query:
    """Load the robot, the scene, start and goals of ``request``; :class:`PlannerError` for unusable ones.

    Configurations of a goal position or pose are chosen by manipulability and by distance to the start; by
    manipulability alone without ``near_start``. Scenes with moving obstacles need ``in_time``: a plan with times.
    """
    path = request.motion_plan_request
    progress("setup", 0, 2)
    message = None if path is None else read_motion_plan_request(path)
    scene, robot = _set_up(request, message)
    if scene.moving and not in_time:
        raise SceneError(
            f"scene '{scene.name}' has moving obstacles ({choices(item.name for item in scene.moving)}), which only a "
            "motion in time avoids: leave out --no-timing or timing=None."
        )
    start, goals = _targets(request, robot, scene, message)
    asked = goals
    if request.cell is not None:
        start, goals = composite_targets(
            load_cell(request.cell), start, goals, request.ik_solutions, request.ik_tolerance
        )
    if request.widen_limits:
        robot = widen_limits_for(robot, [start, *goals])
    _require_limits(robot, [("start", start), *((_role(goal, goals), goal) for goal in goals)])
    robot, constraint = _collect_constraints(request, robot, scene, message)
    _judge(request, robot, scene)
    turns = relative_to_start(constraint)
    bound = [each for each in constraint if each not in turns]
    checker = make_checker(robot, scene, request.collision, request.margin, bound)
    progress("setup", 1, 2)
    query = resolve_query(checker, start, goals, request.ik_solutions, request.ik_tolerance, near_start, turns)
    progress("setup", 2, 2)
    return query if request.cell is None else query.with_texts(asked)


def resolve_query(
    checker: CollisionChecker,
    start: Target,
    goals: Sequence[Target],
    solutions: int,
    tolerance: Tolerance,
    near_start: bool = True,
    turns: tuple[Condition, ...] = (),
) -> Query:
    """Return the configurations of a start and of goals; :class:`StateError` for unusable ones.

    A goal becomes at most ``solutions`` configurations of inverse kinematics within a ``tolerance`` (m, rad).
    ``near_start`` as in :func:`make_query`; ``turns`` are conditions relative to the orientation at the start.
    """
    robot, scene = checker.robot, checker.world.scene
    states = states_of(robot, scene)
    starts = resolve(start, checker, states, "start", tolerance=tolerance)
    if turns:
        checker = _bound(checker, turns, starts[0])
    ends, names = [], []
    for goal in goals:
        near = starts if near_start else None
        ends.append(resolve(goal, checker, states, _role(goal, goals), solutions, near, tolerance))
        names += [goal.text] * len(ends[-1])
    _, rows = np.unique(np.vstack(ends), axis=0, return_index=True)  # two names may be one goal
    rows.sort()
    end_notes = tuple(other_turns(start, checker, states))
    return Query(robot, scene, checker, starts, np.vstack(ends)[rows], tuple(names[row] for row in rows), end_notes)


def _role(goal: Target, goals: Sequence[Target]) -> str:
    return "goal" if len(goals) == 1 else f"goal '{goal.text}'"


def _require_limits(robot: Robot, targets: list[tuple[str, Target]]) -> None:
    """Raise :class:`StateError` for joint values out of limits, with --widen-limits as the remedy."""
    for role, target in targets:
        if isinstance(target, Joints):
            values = joint_values(np.array(target.values), robot, role)
            check_limits(robot, values, role, "bring it inside, or widen them with --widen-limits.")


def _collect_constraints(
    request: WorldRequest, robot: Robot, scene: Scene, message: MotionPlanRequest | None
) -> tuple[Robot, tuple[Condition, ...]]:
    """Return the robot, and the path constraints of the request, the scene and a message."""
    constraint = (*request.constraint, *parse_constraints(scene.constraints))
    if message is not None:
        robot, constraint = (
            with_path_limits(robot, message, scene),
            (*constraint, *path_conditions(message, robot, scene)),
        )
    return robot, tuple(dict.fromkeys(constraint))


def _set_up(request: WorldRequest, message: MotionPlanRequest | None) -> tuple[Scene, Robot]:
    """Return the scene, and the robot in it, with the changes of a MoveIt request."""
    request = open_cell(request)
    scene = with_start_state(Scene.load(request.scene), message)
    return scene, robot_of(request, scene, message)


def states_of(robot: Robot, scene: Scene) -> dict[str, str]:
    """Return the named states of a robot as texts; those of the scene replace those of the SRDF."""
    own = {name: joints_text(values) for name, values in robot.states.items() if name != HOME}
    return {**own, **scene.states_of(robot.name)}


def _targets(
    request: ProblemRequest, robot: Robot, scene: Scene, message: MotionPlanRequest | None
) -> tuple[Target, Sequence[Target]]:
    """Return start and goals; --start and --goal take precedence over the MoveIt request."""
    plain = ProblemRequest()
    start, goals = request.start, request.goal
    if message is not None and request.start == plain.start:
        start = start_joints(message, robot, scene)
    if message is not None and request.goal == plain.goal:
        goals = goal_targets(message, robot, scene)
    return start, goals


def _judge(request: WorldRequest, robot: Robot, scene: Scene) -> None:
    robot_in_scene.require_bodies(robot)
    log_notes(*(note.text for note in robot_in_scene.notes(robot, scene) if note.grave))
