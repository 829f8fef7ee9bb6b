"""A chunk of joint targets as a caller gives it, read into one row of numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, Ints, numbers
from planner.base.errors import ArrayError, StateError
from planner.base.yamlfile import FARTHEST
from planner.query.resolve import position_bounds
from planner.robot.robot import HALF_TURN, Robot
from planner.trajectory.trajectory import whole_nanoseconds

Row = Floats | Sequence[float]
Rows = Floats | Sequence[Sequence[float]]
RobotState = Sequence[Row]
"""Where the robot is: positions, velocities and perhaps accelerations (dof,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Given:
    """What a gate is asked, in one ``row``: times, the ``state``'s rows (dof,), columns (``points``, dof)."""

    points: int
    rows: int
    state: int
    row: Floats


def read_chunk(
    robot: Robot,
    positions: Rows,
    velocities: Rows | None,
    accelerations: Rows | None,
    times: Row,
    state: RobotState | None,
) -> Given:
    """The chunk as numbers.

    Raises :class:`ArrayError` for other shapes, what is no finite number, times that do not increase from 0 on, and no
    points; :class:`StateError` for such a state, one outside the limits on positions, or one that a wheel may leave
    either way round.
    """
    columns = _columns(robot.dof, positions, velocities, accelerations)
    here = np.zeros((0, robot.dof)) if state is None else _state(robot, state)
    clock = _clock(times, len(columns[0]))
    if len(here) and clock[0] > 0:
        _require_one_way(robot, here[0], columns[0][0])
    elif len(clock) < 2:
        raise ArrayError("the chunk is one point and no motion: give a time above 0 and the state, or more points.")
    flat = np.concatenate([numbers("times", times, (len(clock),)), here, *columns], axis=None)
    return Given(len(clock), len(columns), len(here), flat)


def _columns(dof: int, positions: Rows, velocities: Rows | None, accelerations: Rows | None) -> list[Floats]:
    """Positions, and what else is given, as numbers of one shape."""
    if np.size(positions) == 0 if isinstance(positions, np.ndarray) else not positions:
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
    """(2 or 3, dof) position, velocity and perhaps acceleration."""
    given = tuple(state)
    if not 2 <= len(given) <= 3:
        raise StateError(f"state holds {len(given)} rows: give (q, qd), or (q, qd, qdd).")
    found = np.zeros((len(given), robot.dof))
    for k, (row, what) in enumerate(zip(given, ("positions", "velocities", "accelerations"), strict=False)):
        found[k] = numbers(f"the state's {what}", row, (robot.dof,), StateError, FARTHEST)
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
