"""All that the motions of one robot keep: seen in states, proven on whole curves, and states brought to keep it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import StateError
from planner.constraints.pieces import Piece, pieces_of
from planner.kinematics.forward import Chain
from planner.kinematics.tool_bound import Frame, ToolBound
from planner.native.compiled import NativeKeeping
from planner.problem.conditions import Condition, KeepTurn, OfPoint, Quaternion
from planner.robot.poses import quaternion_of
from planner.robot.robot import Robot, with_tool

FORGIVEN = 1e-9  # rad (m): beyond a condition by what was printed and read back
_STEPS = 30  # of a projection
_FINEST = 0.1 * FORGIVEN  # rad (m): pieces that leave their chords by less are not halved


@dataclass(frozen=True, eq=False)
class _Group:
    """Pieces on one frame, and the number of the condition that each belongs to."""

    frame: Frame
    pieces: tuple[Piece, ...]
    of: Ints
    bound: ToolBound


@dataclass(frozen=True)
class Kept:
    """What came of a condition on curves: the least it had to ``spare`` (rad, m), at state ``row``, and its proof."""

    condition: Condition
    spare: float
    row: int
    proven: bool

    @property
    def strays(self) -> bool:
        """Whether it is broken in a state that was looked at."""
        return self.spare < -FORGIVEN

    @property
    def text(self) -> str:
        """As part of a sentence."""
        if self.strays:
            return f"'{self.condition.text}' is broken by {-self.spare:.3g} {self.condition.unit}"
        proof = "proven all along" if self.proven else "NOT proven between what was sampled"
        return f"'{self.condition.text}' with {self.spare:.3g} {self.condition.unit} to spare, {proof}"


@dataclass(frozen=True, eq=False)
class Keeps:
    """Bound ``conditions`` on frames of a ``robot``, of which none may be broken.

        keeps = Keeps(robot, parse_keeps("axis:z,0,0,1,0.1"))
        keeps.holds(q)                          # (n,) in states (n, dof)
        keeps.proven(coefficients)              # (m,) on whole curves (m, degree + 1, dof)

    Of none all of it is True, at no cost. Raises :class:`RobotError` for frames that the robot lacks.
    """

    robot: Robot
    conditions: tuple[Condition, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.conditions)

    @property
    def texts(self) -> tuple[str, ...]:
        return tuple(condition.text for condition in self.conditions)

    @property
    def stride(self) -> float:
        """The joint motion (rad) from one middle of the narrowest condition to another whose chord about keeps it."""
        return min((2.0 * math.sqrt(each.thickness) for each in self.conditions), default=math.inf)

    @cached_property
    def _groups(self) -> tuple[_Group, ...]:
        found: dict[Any, list[tuple[int, Piece]]] = {}
        frames: dict[Any, Frame] = {}
        for number, condition in enumerate(self.conditions):
            point = condition.point if isinstance(condition, OfPoint) else (0.0, 0.0, 0.0)
            key = condition.frame, point
            frames[key] = frame_of(self.robot, *key)
            found.setdefault(key, []).extend((number, piece) for piece in pieces_of(condition))
        return tuple(
            _Group(
                frames[key],
                tuple(piece for _, piece in rows),
                np.array([number for number, _ in rows]),
                ToolBound(self.robot, frames[key]),
            )
            for key, rows in found.items()
            if rows
        )

    @cached_property
    def _native(self) -> NativeKeeping:
        """The same in the compiled library, which says what is to spare, and projects."""
        groups, pieces = self._groups, [piece for group in self._groups for piece in group.pieces]
        none = np.zeros((0, 4, 4)), np.zeros((0, 12)), np.zeros(0)
        return NativeKeeping(
            Chain.of(self.robot).native,
            np.array([group.frame.joint for group in groups], dtype=np.int64),
            np.concatenate([none[0], *(group.frame.placement[None] for group in groups)]),
            np.array([len(group.pieces) for group in groups], dtype=np.int64),
            np.array([len(piece.rows) for piece in pieces], dtype=np.int64),
            np.array([piece.ball for piece in pieces], dtype=bool),
            np.concatenate([none[1], *(piece.rows for piece in pieces)]),
            np.concatenate([none[2], *(piece.centre for piece in pieces)]),
            np.array([piece.limit for piece in pieces], dtype=float),
            np.array([piece.depth for piece in pieces], dtype=float),
            (self.robot.lower, self.robot.upper, self.robot.continuous),
        )

    def _slacks(self, q: Floats) -> list[Floats]:
        """(n, k) for the pieces of each group what they have to spare in states (n, dof); negative where broken."""
        frames = [group.frame for group in self._groups]
        return [self._native.slack(k, *frame.poses(self.robot, q)) for k, frame in enumerate(frames)]

    def spare(self, q: Floats) -> Floats:
        """(n, conditions) what each has to spare in states (n, dof), m or rad; negative where it is broken."""
        least = np.full((len(q), len(self.conditions)), np.inf)
        for group, slack in zip(self._groups, self._slacks(q), strict=True):
            for k, number in enumerate(group.of.tolist()):
                least[:, number] = np.minimum(least[:, number], group.pieces[k].spare(slack[:, k]))
        return least

    def slack(self, q: Floats) -> Floats:
        """(n,) the least that a piece has to spare in states (n, dof)."""
        return np.concatenate([np.full((len(q), 1), np.inf), *self._slacks(q)], axis=1).min(axis=1)

    def holds(self, q: Floats) -> Bools:
        """(n,) in which states (n, dof) all are kept."""
        return self._brought(q, 0.0, FORGIVEN, 0)[1] if self else np.ones(len(q), dtype=bool)

    def proven(self, coefficients: Floats) -> Bools:
        """(m,) on which curves sum_k c_k s^k, s in [0, 1], (m, degree + 1, dof), all are proven to be kept."""
        if not self:
            return np.ones(len(coefficients), dtype=bool)
        return self._native.proven(coefficients, self._bounds, FORGIVEN, _FINEST)

    @cached_property
    def _bounds(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """What ``NativeKeeping.proven`` asks of frames and pieces."""
        groups, dof = self._groups, self.robot.dof
        pieces = [piece for group in groups for piece in group.pieces]
        return (
            np.reshape([group.bound.reach for group in groups], (-1, dof)),
            np.reshape([group.bound.rates for group in groups], (-1, dof, dof)),
            np.reshape([group.bound.turns for group in groups], (-1, dof)),
            np.array([piece.per_metre for piece in pieces], dtype=float),
            np.array([piece.per_turn for piece in pieces], dtype=float),
        )

    def along(self, q: Floats, coefficients: Floats) -> tuple[Kept, ...]:
        """What came of each condition on curves (m, degree + 1, dof), and on states of them (n, dof)."""
        alone = [replace(self, conditions=(each,)) for each in self.conditions]
        spare = self.spare(q)
        return tuple(
            Kept(each, float(spare[:, k].min()), int(spare[:, k].argmin()), bool(alone[k].proven(coefficients).all()))
            for k, each in enumerate(self.conditions)
        )

    def projected(self, q: Floats, depth: Floats | float = 0.5, exact: float = FORGIVEN) -> tuple[Floats, Bools]:
        """States near ``q`` (n, dof), within joint limits, that keep all, and which do (n,), forgiving ``exact``.

        By Gauss-Newton steps into what is allowed, a share ``depth`` (n,) of the way to its middle; those that keep all
        already stay as they are. Continuous joints may turn beyond half a turn.
        """
        return self._brought(q, depth, exact, _STEPS)

    def _brought(self, q: Floats, depth: Floats | float, exact: float, steps: int) -> tuple[Floats, Bools]:
        return self._native.projected(q, np.full(len(q), depth), exact, steps)


def frame_of(robot: Robot, name: str | None, point: Sequence[float] = (0.0, 0.0, 0.0)) -> Frame:
    """A frame of the robot, its tool where no name is given, moved to a point of it (m)."""
    return Frame.tool(with_tool(robot, name), np.array(point))


def bound_to(conditions: Iterable[Condition], robot: Robot, start: Floats) -> tuple[Condition, ...]:
    """Conditions with the orientation that their frames have at the ``start`` (dof,), where they name none."""
    return tuple(
        replace(each, quaternion=_orientation(robot, each.frame, start)) if each in unbound([each]) else each
        for each in conditions
    )


def _orientation(robot: Robot, frame: str | None, q: Floats) -> Quaternion:
    rotation, _ = frame_of(robot, frame).poses(robot, q[None])
    x, y, z, w = (round(float(value), 9) for value in quaternion_of(rotation[0]))  # to be read
    return x, y, z, w


def unbound(conditions: Iterable[Condition]) -> tuple[Condition, ...]:
    """Those that mean the orientation at the start."""
    return tuple(each for each in conditions if isinstance(each, KeepTurn) and each.quaternion is None)


def require_bound(conditions: tuple[Condition, ...], robot: Robot) -> None:
    """Raise :class:`PlannerError` for what means a start where there is none, or a frame that is not there."""
    for each in unbound(conditions):
        raise StateError(f"'{each.text}' means the orientation at a start, and here is none: add qx,qy,qz,qw to it.")
    for each in conditions:
        frame_of(robot, each.frame)
