"""A chunk of joint targets as a joint trajectory controller runs it: from where the robot is, piece after piece."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, Ints, numbers
from planner.base.errors import ArrayError, StateError
from planner.base.yamlfile import FARTHEST
from planner.models.robot import Robot
from planner.setup.resolve import beyond_limits
from planner.trajectory.trajectory import pieces_through, whole_nanoseconds

Row = Floats | Sequence[float]
Rows = Floats | Sequence[Sequence[float]]
RobotState = Sequence[Row]
"""Where the robot is: positions, velocities and perhaps accelerations (dof,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """Pieces (n, degree + 1, dof) between ``times`` (n + 1,) s from now, each takes ``seconds`` (n,).

    ``knots`` (n + 1, 3, dof): position, velocity and acceleration with which the motion comes to each of the times, at
    the first one those of the robot. ``degree`` is 1, 3 or 5, of lines, cubics or quintics. ``approach`` (2, dof) is
    where the robot is and by how much the first point, which is at 0 s, is elsewhere; None where the first piece leads
    there. ``rough``: the first of quintics is a cubic, as nobody gives the robot's acceleration.
    """

    times: Floats
    seconds: Floats
    coefficients: Floats
    knots: Floats
    degree: int
    approach: Floats | None = None
    rough: bool = False

    @staticmethod
    def of(
        robot: Robot,
        positions: Rows,
        velocities: Rows | None,
        accelerations: Rows | None,
        times: Row,
        state: RobotState | None,
    ) -> Chunk:
        """What is run of points (k, dof) at ``times`` (k,) s, by a robot in ``state``.

        As joint_trajectory_controller has it: until the first point's time the piece leads there from where the robot
        is, of the highest degree that both know the derivatives for. Raises :class:`ArrayError` for other shapes, what
        is no finite number, times that do not increase from 0 on, and no points; :class:`StateError` for such a state,
        one outside the limits on positions, or one that a wheel may leave either way round.
        """
        columns = _columns(robot.dof, positions, velocities, accelerations)
        here = None if state is None else _state(robot, state)
        clock = _clock(times, len(columns[0]))
        approach = rough = None
        if here is not None and clock[0] > 0:
            _require_one_way(robot, here[0], columns[0][0])
            rough = len(columns) == 3 and len(state or ()) < 3
            columns = [np.concatenate([row[None], column]) for row, column in zip(here, columns, strict=False)]
            clock = np.concatenate([np.zeros(1, dtype=np.int64), clock])
        elif here is not None:
            approach = np.stack([here[0], columns[0][0] - here[0]])
        if len(clock) < 2:
            raise ArrayError("the chunk is one point and no motion: give a time above 0 and the state, or more points.")
        seconds = (clock[1:] - clock[:-1]) / 1e9
        pieces = pieces_through(seconds[:, None], *columns)
        if rough:
            pieces[0], pieces[0, :4] = 0.0, pieces_through(seconds[:1, None], columns[0][:2], columns[1][:2])[0]
        knots = _knots(pieces, seconds, columns, here, bool(rough))
        return Chunk(clock / 1e9, seconds, pieces, knots, 2 * len(columns) - 1, approach, bool(rough))

    def jump(self) -> Floats:
        """How far (dof,) a first point at 0 s is from where the robot is, and from its velocity where it says one."""
        if self.approach is None:
            return np.zeros(1)
        faster = self.coefficients[0, 1] / self.seconds[0] - self.knots[0, 1] if self.degree > 1 else 0.0
        return np.maximum(np.abs(self.approach[1]), np.abs(faster))


def _columns(dof: int, positions: Rows, velocities: Rows | None, accelerations: Rows | None) -> list[Floats]:
    """Positions, and what else is given, as numbers of one shape."""
    if np.shape(np.asarray(positions))[:1] == (0,):
        raise ArrayError("the chunk is empty: give at least one point.")
    if velocities is None and accelerations is not None:
        raise ArrayError("accelerations say nothing without velocities: give velocities too.")
    found = [numbers("positions", positions, ("k", dof), most=FARTHEST)]
    for what, column in (("velocities", velocities), ("accelerations", accelerations)):
        if column is not None:
            found.append(numbers(what, column, found[0].shape, most=FARTHEST))
    return found


def _clock(times: Row, count: int) -> Ints:
    clock = whole_nanoseconds(numbers("times", times, (count,)))
    later = clock[1:] > clock[:-1]
    if clock[0] < 0 or not later.all():
        k = 0 if later.all() else int(later.argmin()) + 1
        raise ArrayError(f"times[{k}] is {times[k]:g} s: times have to increase strictly, from 0 s, which is now, on.")
    return clock


def _state(robot: Robot, state: RobotState) -> Floats:
    """(3, dof) position, velocity and acceleration, 0 where that is not given."""
    if not 2 <= len(state) <= 3:
        raise StateError(f"state holds {len(state)} rows: give (q, qd), or (q, qd, qdd).")
    found = np.zeros((3, robot.dof))
    for row, what in zip(range(len(state)), ("positions", "velocities", "accelerations"), strict=False):
        found[row] = numbers(f"the state's {what}", state[row], (robot.dof,), StateError, FARTHEST)
    beyond = beyond_limits(robot, found[0])
    if beyond.any():
        j = int(beyond.argmax())
        limits = f"[{robot.lower[j]:g}, {robot.upper[j]:g}]"
        raise StateError(
            f"the state is outside the limits: joint '{robot.joints[j]}' is at {found[0, j]:g}, not in {limits}; "
            "bring it back by hand."
        )
    return found


def _require_one_way(robot: Robot, here: Floats, first: Floats) -> None:
    """Refuse a continuous joint more than half a turn from the first point: some controllers turn it the short way."""
    far = robot.continuous & (np.abs(first - here) > np.pi)
    if far.any():
        joint = robot.joints[int(far.argmax())]
        raise StateError(
            f"joint '{joint}' is more than half a turn from the first point, and controllers differ on which way round "
            "it goes: add whole turns to one of the two, or points between them."
        )


def _knots(pieces: Floats, seconds: Floats, columns: list[Floats], here: Floats | None, rough: bool) -> Floats:
    """See :class:`Chunk`."""
    h, powers = seconds[:, None], pieces.shape[1]
    knots = np.zeros((len(pieces) + 1, 3, pieces.shape[2]))
    for order, column in enumerate(columns):
        knots[:, order] = column
    if powers == 2:
        knots[1:, 1] = pieces[:, 1] / h
    last = len(pieces) if powers == 4 else int(rough)  # cubics: the next piece begins with another acceleration
    if last:
        knots[1 : last + 1, 2] = (2.0 * pieces[:last, 2] + 6.0 * pieces[:last, 3]) / h[:last] ** 2
    if here is not None:
        knots[0] = here
    return knots
