"""The gate between a program that decides what a robot does next and the robot."""

from collections.abc import Sequence
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
from planner.session.live_world import LiveWorld
from planner.session.verdict import JUDGED, Guard, Rules, Verdict, judge_chunk
from planner.trajectory.limits import MotionLimits, limits_or_default
from planner.trajectory.trajectory import to_nanoseconds

Row: TypeAlias = Floats | Sequence[float]
Rows: TypeAlias = Floats | Sequence[Sequence[float]]
RobotState: TypeAlias = Sequence[Row]
"""Where the robot is: positions, velocities and perhaps accelerations (dof,)."""


class Gate:
    """Says whether what a robot is about to do is proven safe, and until when; half a millisecond a chunk.

        gate = planner.Gate("panda", "shelf", margin=0.01)
        verdict = gate.check(targets, times=[0.1, 0.2, 0.3], state=(q, qd))
        verdict.safe, verdict.safe_until, verdict.reason, verdict.stop

    ``robot`` and ``scene`` by name, file or as loaded, or the ``world`` of a :class:`planner.Session` alone, whose
    margin and conditions it then keeps. Obstacles are moved, added, taken and put down by ``gate.world``, see
    :class:`LiveWorld`; the next check knows. ``limits``: the robot's own where left out; ``judged`` are those that are
    asked for, of position, velocity, acceleration and jerk. ``min_manipulability`` is kept by all that is run, stops
    too, and so is what the scene and ``constraint`` say. ``margin`` (m) is kept to everything; a larger one refuses
    more. A first point at 0 s may be ``start_tolerance`` (rad, m, these per s and s²) from the robot's state. A check
    changes nothing: several threads may check at once, also while another changes the world. Raises
    :class:`PlannerError` for what cannot be loaded, and where obstacles move along known motions.
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
            kept = read_conditions(constraint)
            there = EMPTY if scene is None else scene
            self.world = LiveWorld(
                WorldRequest(robot, there, tool, collision=collision, margin=margin, constraint=kept)
            )
        asked = limits if isinstance(limits, MotionLimits) else MotionLimits.from_robot(self.world.robot, limits)
        self.limits: MotionLimits = limits_or_default(asked, self.world.robot)
        """The limits that are kept, as far as they are judged."""
        self._rules = Rules.from_limits(self.world.robot, asked, judged, min_manipulability, start_tolerance)
        self._guard = Guard.from_checker(*self.world.now, self._rules)
        self.checker.make_ready()  # its trees of triangles: no check waits for them

    def __repr__(self) -> str:
        return f"<Gate: {self.robot.name} in {self.scene.name}>"

    @property
    def robot(self) -> Robot:
        """The robot with what it carries now."""
        return self.world.robot

    @property
    def scene(self) -> Scene:
        """The scene as it is now, with what the arm carries."""
        return self.world.scene

    @property
    def checker(self) -> CollisionChecker:
        """The checker of the world as it is now."""
        return self.world.checker

    def to_dict(self) -> dict[str, Any]:
        """What is judged, as plain data, and the revision of the world."""
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
        """Whether targets (k, dof), rad (m) in the robot's order of joints, at ``times`` (k,) s after now, are safe.

        Proven is what joint_trajectory_controller runs: lines where only positions are given, cubics with velocities,
        quintics with accelerations too, from ``state`` = (q, qd) or (q, qd, qdd), (dof,) each, on; from the first point
        on where no state is given. With ``stop`` a stop is proven from every point, too. What is not decided is not
        safe. Raises :class:`ArrayError` for other shapes, NaN, times that do not increase, and no points,
        :class:`StateError` for a state outside limits; the gate goes on.
        """
        guard = self._current_guard()
        chunk = _read_chunk(guard.checker.robot, (positions, velocities, accelerations), times, state)
        return judge_chunk(guard, *chunk, stop)

    def _current_guard(self) -> Guard:
        """The guard of the world as it is now."""
        guard, (checker, revision) = self._guard, self.world.now
        if guard.revision != revision:
            self._guard = guard = Guard.from_checker(checker, revision, self._rules)
        return guard


def _read_chunk(
    robot: Robot, columns: tuple[Rows, Rows | None, Rows | None], times: Row, state: RobotState | None
) -> tuple[int, int, int, Floats]:
    """How many points, columns and rows of ``state`` there are, and times, ``state``, columns in one row of numbers."""
    if columns[1] is None and columns[2] is not None:
        raise ArrayError("accelerations need velocities: give those too.")
    given = [numbers("positions", columns[0], ("k", robot.dof), most=FARTHEST)]
    for what, column in zip(("velocities", "accelerations"), columns[1:], strict=True):
        if column is not None:
            given.append(numbers(what, column, given[0].shape, most=FARTHEST))
    here = np.zeros((0, robot.dof)) if state is None else _read_state(robot, state)
    seconds = numbers("times", times, (len(given[0]),))
    clock = to_nanoseconds(seconds)
    if not len(clock):
        raise ArrayError("positions must hold a point or more, got none.")
    later = clock[1:] > clock[:-1]
    if clock[0] < 0 or not later.all():
        k = 0 if later.all() else int(later.argmin()) + 1
        raise ArrayError(f"times must increase strictly from 0 s, which is now, got times[{k}] = {seconds[k]:g} s.")
    if len(here) and clock[0] > 0:
        _require_one_way(robot, here[0], given[0][0])
    elif len(clock) < 2:
        raise ArrayError("the chunk is one point and no motion: give a time above 0 and the state, or more points.")
    return len(clock), len(given), len(here), np.concatenate([seconds, here, *given], axis=None)


def _read_state(robot: Robot, state: RobotState) -> Floats:
    """(2 or 3, dof) position, velocity and perhaps acceleration."""
    found = numbers("state", list(state), ("n", robot.dof), StateError, FARTHEST)
    if not 2 <= len(found) <= 3:
        raise StateError(f"state holds {len(found)} rows: give (q, qd), or (q, qd, qdd).")
    lower, upper = position_bounds(robot)
    beyond = (found[0] < lower) | (found[0] > upper)
    if beyond.any():
        j = int(beyond.argmax())
        limits = f"[{robot.lower[j]:g}, {robot.upper[j]:g}]"
        raise StateError(
            f"the state is outside the limits: joint '{robot.joints[j]}' is at {found[0, j]:g}, not in {limits}; "
            "bring it back by hand."
        )
    return found


def _require_one_way(robot: Robot, here: Floats, first: Floats) -> None:
    """Refuse a continuous joint half a turn or more from the first point: some controllers turn it the short way."""
    far = robot.continuous & (np.abs(first - here) > HALF_TURN)
    if far.any():
        joint = robot.joints[int(far.argmax())]
        raise StateError(
            f"joint '{joint}' is half a turn or more from the first point, and controllers differ on which way round "
            "it goes: add whole turns to one of the two, or points between them."
        )
