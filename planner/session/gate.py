"""The gate between a robot and the program that commands it."""

from collections.abc import Sequence
from dataclasses import replace
from time import monotonic
from typing import Any, TypeAlias

import numpy as np

from planner.base.arrays import Floats, numbers
from planner.base.errors import ArrayError, StateError
from planner.base.yamlfile import FARTHEST
from planner.collision.checker import CollisionChecker
from planner.kinematics.arm import HALF_TURN
from planner.problem.conditions import read_conditions
from planner.problem.options import EMPTY, ROBOT, SCENE, Backend, RobotLike, SceneLike
from planner.problem.request import LimitsRequest, WorldRequest
from planner.query.resolve import position_bounds
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.session.guard import JUDGED, Guard, Rules
from planner.session.live_world import LiveWorld
from planner.session.reasons import Statistics
from planner.session.verdict import Verdict, judge_chunk
from planner.trajectory.limits import MotionLimits, limits_or_default
from planner.trajectory.trajectory import to_nanoseconds

Row: TypeAlias = Floats | Sequence[float]
Rows: TypeAlias = Floats | Sequence[Sequence[float]]
RobotState: TypeAlias = Sequence[Row]
"""State of the robot: positions, velocities and optionally accelerations (dof,)."""


class Gate:
    """Decides whether commanded targets are proven safe, and until when; half a millisecond per chunk.

        gate = planner.Gate("panda", "shelf", margin=0.01)
        verdict = gate.check(targets, times=[0.1, 0.2, 0.3], state=(q, qd))
        verdict.safe, verdict.safe_until, verdict.reason, verdict.stop

    ``robot`` and ``scene`` are names, files or objects; ``robot`` alone can be the ``world`` of a
    :class:`planner.Session`, whose margin and constraints then hold. ``gate.world`` changes obstacles, see
    :class:`LiveWorld`, from the next check on. ``limits`` are by default those of the robot; ``judged`` selects the
    checked ones of position, velocity, acceleration and jerk. ``min_manipulability``, the constraints of the scene and
    ``constraint`` hold for all motions, stops too. A larger ``margin`` (m) refuses more. A first point at 0 s can be
    ``start_tolerance`` (rad, m, per s and s²) from the robot's state. A check changes nothing: several threads can
    check at once, also while another changes the world. Raises :class:`PlannerError` for unusable input, and if
    obstacles move along known motions.
    """

    def __init__(
        self,
        robot: RobotLike | LiveWorld = ROBOT,
        scene: SceneLike = SCENE,
        *,
        limits: MotionLimits | LimitsRequest | None = None,
        judged: Sequence[str] = JUDGED,
        min_manipulability: float = 0.0,
        margin: float = 0.0,
        start_tolerance: float = 0.01,
        tool: str | None = None,
        collision: Backend = "fcl",
        constraint: object = (),
    ) -> None:
        if isinstance(robot, LiveWorld):
            self.world = robot
        else:
            constraints = read_conditions(constraint)
            there = EMPTY if scene is None else scene
            self.world = LiveWorld(
                WorldRequest(robot, there, tool=tool, collision=collision, margin=margin, constraint=constraints)
            )
        given = limits if isinstance(limits, MotionLimits) else MotionLimits.from_robot(self.world.robot, limits)
        self.limits: MotionLimits = limits_or_default(given, self.world.robot)
        """The limits of motions, as far as ``judged`` selects them."""
        self._rules = Rules.from_limits(self.world.robot, given, judged, min_manipulability, start_tolerance)
        self.statistics = Statistics()
        """Counts of verdicts and of their reasons."""
        self._guard = Guard.from_checker(*self.world.now, self._rules, self.statistics)
        self.checker.make_ready()  # builds trees of triangles, so no check waits for them

    def __repr__(self) -> str:
        return f"<Gate: {self.robot.name} in {self.scene.name}>"

    @property
    def robot(self) -> Robot:
        """The current robot, with carried objects."""
        return self.world.robot

    @property
    def scene(self) -> Scene:
        """The current scene, with carried objects."""
        return self.world.scene

    @property
    def checker(self) -> CollisionChecker:
        """The checker of the current world."""
        return self.world.checker

    def to_dict(self) -> dict[str, Any]:
        """Return limits, rules and the revision of the world as plain data."""
        return {"limits": self.limits.to_dict(), **self._current_guard().to_dict()}

    def check(
        self,
        positions: Rows,
        velocities: Rows | None = None,
        accelerations: Rows | None = None,
        *,
        times: Row,
        state: RobotState | None = None,
        stop: bool = True,
    ) -> Verdict:
        """Prove targets (k, dof), rad (m) in the robot's order of joints, at ``times`` (k,) s from now.

        The proof covers the motion of joint_trajectory_controller: lines for positions only, cubics with velocities,
        quintics with accelerations too, from ``state`` = (q, qd) or (q, qd, qdd), (dof,) each, or else from the first
        point. ``stop`` also proves a stop from every point. An undecided motion is not safe. Raises
        :class:`ArrayError` for wrong shapes, NaN, times that do not increase, and no points; :class:`StateError` for a
        state outside limits. The gate stays usable.
        """
        guard = self._current_guard()
        chunk = _read_chunk(guard.checker.robot, (positions, velocities, accelerations), times, state)
        verdict = judge_chunk(guard, *chunk, stop)
        self.statistics.count(verdict.outcome, verdict.reason)
        return verdict

    def allow(
        self, link: str, object: str, *, seconds: float | None = None, box: Floats | Sequence[float] | None = None
    ) -> None:
        """Allow one pair to touch, see :meth:`LiveWorld.allow`; notes of verdicts name the pair.

        gate.allow("panda_leftfinger", "cup", seconds=2.0)
        """
        self.world.allow(link, object, seconds, box)

    def forbid(self, link: str, object: str) -> None:
        """End the permission of a pair; :class:`SceneError` if it has none."""
        self.world.forbid(link, object)

    def _current_guard(self) -> Guard:
        """Return the guard of the current world."""
        now, permissions, guard, (checker, revision) = monotonic(), self.world.permissions, self._guard, self.world.now
        if permissions:
            permissions = tuple(item for item in permissions if item.until > now)
        if guard.revision != revision or guard.permissions != permissions:
            guard = Guard.from_checker(checker, revision, self._rules, self.statistics, permissions)
            self._guard = guard
        return replace(guard, now=now) if permissions else guard


def _read_chunk(
    robot: Robot, columns: tuple[Rows, Rows | None, Rows | None], times: Row, state: RobotState | None
) -> tuple[int, int, int, Floats]:
    """Return counts of points, columns and rows of ``state``, and all numbers in one array."""
    if columns[1] is None and columns[2] is not None:
        raise ArrayError("accelerations need velocities: give both.")
    given = [numbers("positions", columns[0], ("k", robot.dof), most=FARTHEST)]
    for what, column in zip(("velocities", "accelerations"), columns[1:], strict=True):
        if column is not None:
            given.append(numbers(what, column, given[0].shape, most=FARTHEST))
    here = np.zeros((0, robot.dof)) if state is None else _read_state(robot, state)
    seconds = numbers("times", times, (len(given[0]),))
    clock = to_nanoseconds(seconds)
    if not len(clock):
        raise ArrayError("positions must have a point or more, got none: give one.")
    later = clock[1:] > clock[:-1]
    if clock[0] < 0 or not later.all():
        k = 0 if later.all() else int(later.argmin()) + 1
        raise ArrayError(f"times must increase strictly from 0 s, got times[{k}] = {seconds[k]:g} s: sort them.")
    if len(here) and clock[0] > 0:
        _require_one_way(robot, here[0], given[0][0])
    elif len(clock) < 2:
        raise ArrayError(
            "a chunk must have a motion, got one point: give a time above 0 and the state, or more points."
        )
    return len(clock), len(given), len(here), np.concatenate([seconds, here, *given], axis=None)


def _read_state(robot: Robot, state: RobotState) -> Floats:
    """Return position, velocity and optionally acceleration (2 or 3, dof)."""
    rows = numbers("state", list(state), ("n", robot.dof), StateError, FARTHEST)
    if not 2 <= len(rows) <= 3:
        raise StateError(f"state must have 2 or 3 rows, got {len(rows)}: give (q, qd), or (q, qd, qdd).")
    lower, upper = position_bounds(robot)
    beyond = (rows[0] < lower) | (rows[0] > upper)
    if beyond.any():
        j = int(beyond.argmax())
        limits = f"[{robot.lower[j]:g}, {robot.upper[j]:g}]"
        raise StateError(
            f"state of joint '{robot.joints[j]}' must be in {limits}, got {rows[0, j]:g}: move the joint back by hand."
        )
    return rows


def _require_one_way(robot: Robot, here: Floats, first: Floats) -> None:
    """Raise :class:`StateError` for a turn of half a turn or more: some controllers take the short way."""
    far = robot.continuous & (np.abs(first - here) > HALF_TURN)
    if far.any():
        joint = robot.joints[int(far.argmax())]
        raise StateError(
            f"joint '{joint}' must start less than half a turn from the first point, as controllers differ in the "
            "direction: add whole turns to one of the two, or points between them."
        )
