"""The path constraints of one robot: checks of states, proofs of curves, projection of states.

Conditions become convex sets of a frame's pose, half-spaces and balls, which hold between the ends of a chord. With y =
(x, rows of R), the position (m) and rotation of a frame as a vector of twelve, each is H y >= d or |B y - c| <= r. An
axis R e within an angle a of n is |R e - n| <= 2 sin(a/2), an orientation within a of R0 is |R - R0| <= 2 sqrt(2)
sin(a/2) in the Frobenius norm, for a up to pi, because all of these lie on a sphere.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.errors import RobotError, StateError
from planner.constraints.tool_bound import Frame, ToolBound
from planner.kinematics.forward import Chain
from planner.native.compiled import NativeConstraints
from planner.problem.conditions import (
    AxisConstraint,
    BoxConstraint,
    Condition,
    OfPoint,
    OrientationConstraint,
    PlaneConstraint,
    PositionConstraint,
    Quaternion,
    Three,
)
from planner.robot.poses import pose, quaternion_of
from planner.robot.robot import Robot, with_tool

FORGIVEN = 1e-9  # rad (m): tolerance for values that were printed and read again
_STEPS = 30  # of a projection
_FINEST = 0.1 * FORGIVEN  # rad (m): intervals with less deviation from the chord are not halved
_DEEP = 5e-3  # m: depth to which states are projected into an unbounded half-space


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex set: one row . y >= ``limit``, or a ``ball`` |rows y - ``centre`` (k,)| <= ``limit``.

    ``rows`` is (k, 12). The slack changes at most by ``per_metre`` of the position, and by ``per_turn`` of the length
    by which a unit vector rotates. ``depth`` is the additional depth of a half-space; ``across`` is the distance for an
    angle of half a turn: a distance d is the angle 2 asin(d / across); 0 for a distance in m.
    """

    rows: Floats
    centre: Floats
    limit: float
    ball: bool
    per_metre: float = 0.0
    per_turn: float = 0.0
    depth: float = 0.0
    across: float = 0.0

    def to_units(self, slack: Floats) -> Floats:
        """Return a slack in m or rad."""
        if not self.across:
            return slack
        ends = np.clip(np.stack([np.full_like(slack, self.limit), self.limit - slack]) / self.across, 0.0, 1.0)
        return 2.0 * (np.arcsin(ends[0]) - np.arcsin(ends[1]))


def _half(normal: Floats, limit: float, depth: float) -> Piece:
    row = np.append(normal, np.zeros(9))
    return Piece(frozen(row[None]), frozen([0.0]), limit, False, float(np.linalg.norm(normal)), depth=depth)


def pieces_of(condition: Condition) -> list[Piece]:
    """Return the convex sets of a condition; an orientation needs its quaternion."""
    match condition:
        case AxisConstraint(axis, direction, angle):
            return [_axis("xyz".index(axis), _unit(direction), angle)]
        case BoxConstraint(lower, upper):
            return [
                _half(sign * np.eye(3)[k], sign * end, 0.5 * (high - low))
                for k, (low, high) in enumerate(zip(lower, upper, strict=True))
                for sign, end in ((1.0, low), (-1.0, high))
            ]
        case PlaneConstraint(normal, distance):
            size = math.hypot(*normal)
            return [_half(_unit(normal), distance / size, _DEEP)]
        case PositionConstraint(radius, position):
            assert position is not None  # bound
            return [Piece(frozen(np.eye(12)[:3]), frozen(position), radius, True, per_metre=1.0)]
        case OrientationConstraint(angle):
            return [_turn(_matrix(condition.quaternion), angle)]
    raise TypeError(f"condition must be a path constraint, got {type(condition).__name__}.")


def _matrix(quaternion: Quaternion | None) -> Floats:
    assert quaternion is not None  # bound
    return pose(quaternion=quaternion)[:3, :3]


def _unit(vector: Three) -> Floats:
    return np.array(vector) / math.hypot(*vector)


def _axis(k: int, direction: Floats, angle: float) -> Piece:
    rows = np.zeros((3, 12))
    rows[range(3), [3 + 3 * i + k for i in range(3)]] = 1.0
    return Piece(frozen(rows), frozen(direction), 2.0 * math.sin(0.5 * angle), True, per_turn=1.0, across=2.0)


def _turn(matrix: Floats, angle: float) -> Piece:
    across = 2.0 * math.sqrt(2.0)
    radius = across * math.sin(0.5 * min(angle, math.pi))
    return Piece(frozen(np.eye(12)[3:]), frozen(matrix.ravel()), radius, True, per_turn=math.sqrt(2.0), across=across)


@dataclass(frozen=True, eq=False)
class _Group:
    """Convex sets on one frame, and the number of each one's condition."""

    frame: Frame
    pieces: tuple[Piece, ...]
    of: Ints
    bound: ToolBound


@dataclass(frozen=True)
class ConstraintReport:
    """Least slack (rad, m) of a condition on curves, at state ``row``, and whether it is proven."""

    condition: Condition
    slack: float
    row: int
    proven: bool

    @property
    def violates(self) -> bool:
        """Whether a sampled state violates it."""
        return self.slack < -FORGIVEN

    @property
    def text(self) -> str:
        """The report as part of a sentence."""
        if self.violates:
            return f"'{self.condition.text}' is broken by {-self.slack:.3g} {self.condition.unit}"
        proof = "proven all along" if self.proven else "NOT proven between what was sampled"
        return f"'{self.condition.text}' with {self.slack:.3g} {self.condition.unit} to spare, {proof}"


@dataclass(frozen=True, eq=False)
class PathConstraints:
    """Conditions on frames of a ``robot`` that all must hold.

        constraints = PathConstraints(robot, parse_constraints("axis:z,0,0,1,0.1"))
        constraints.holds(q)                          # (n,) in states (n, dof)
        constraints.prove(coefficients)              # (m,) on curves (m, degree + 1, dof)

    Orientations must have their quaternions. Raises :class:`RobotError` for unknown frames.
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
        """Joint motion (rad) between middles of the narrowest condition whose chord roughly satisfies it."""
        return min((2.0 * math.sqrt(each.thickness) for each in self.conditions), default=math.inf)

    @cached_property
    def _groups(self) -> tuple[_Group, ...]:
        by_frame: dict[Any, list[tuple[int, Piece]]] = {}
        frames: dict[Any, Frame] = {}
        for number, condition in enumerate(self.conditions):
            point = condition.point if isinstance(condition, OfPoint) else (0.0, 0.0, 0.0)
            key = condition.frame, point, condition.base
            frames[key] = frame_of(self.robot, *key)
            by_frame.setdefault(key, []).extend((number, piece) for piece in pieces_of(condition))
        return tuple(
            _Group(
                frames[key],
                tuple(piece for _, piece in rows),
                np.array([number for number, _ in rows]),
                ToolBound(self.robot, frames[key]),
            )
            for key, rows in by_frame.items()
            if rows
        )

    @cached_property
    def _native(self) -> NativeConstraints:
        """The compiled constraints."""
        groups, pieces = self._groups, [piece for group in self._groups for piece in group.pieces]
        none = np.zeros((0, 4, 4)), np.zeros((0, 12)), np.zeros(0)
        bases = [group.frame.base for group in groups]
        return NativeConstraints(
            Chain.from_arm(self.robot).native,
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
            np.array([-1 if base is None else base.joint for base in bases], dtype=np.int64),
            np.concatenate([none[0], *(np.eye(4)[None] if base is None else base.placement[None] for base in bases)]),
        )

    def _slacks(self, q: Floats) -> list[Floats]:
        """Return slacks (n, k) of each group's sets in states (n, dof)."""
        frames = [group.frame for group in self._groups]
        return [self._native.slack(k, *frame.poses(self.robot, q)) for k, frame in enumerate(frames)]

    def slacks(self, q: Floats) -> Floats:
        """Return each condition's slack (n, conditions) in states (n, dof), m or rad; below 0 if violated."""
        least = np.full((len(q), len(self.conditions)), np.inf)
        for group, slack in zip(self._groups, self._slacks(q), strict=True):
            for k, number in enumerate(group.of.tolist()):
                least[:, number] = np.minimum(least[:, number], group.pieces[k].to_units(slack[:, k]))
        return least

    def least_slack(self, q: Floats) -> Floats:
        """Return the least slack (n,) of any set in states (n, dof)."""
        return np.concatenate([np.full((len(q), 1), np.inf), *self._slacks(q)], axis=1).min(axis=1)

    def holds(self, q: Floats) -> Bools:
        """Return which states (n, dof) satisfy all conditions, (n,)."""
        return self._project(q, 0.0, FORGIVEN, 0)[1] if self else np.ones(len(q), dtype=bool)

    def prove(self, coefficients: Floats) -> Bools:
        """Return which curves sum_k c_k s^k, (m, degree + 1, dof), provably satisfy all, (m,)."""
        if not self:
            return np.ones(len(coefficients), dtype=bool)
        return self._native.proven(coefficients, self._rates, FORGIVEN, _FINEST)

    @cached_property
    def _rates(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Arguments of ``NativeConstraints.proven`` for frames and sets."""
        groups, dof = self._groups, self.robot.dof
        pieces = [piece for group in groups for piece in group.pieces]
        return (
            np.reshape([group.bound.reach for group in groups], (-1, dof)),
            np.reshape([group.bound.rates for group in groups], (-1, dof, dof)),
            np.reshape([group.bound.turns for group in groups], (-1, dof)),
            np.array([piece.per_metre for piece in pieces], dtype=float),
            np.array([piece.per_turn for piece in pieces], dtype=float),
        )

    def along(self, q: Floats, coefficients: Floats) -> tuple[ConstraintReport, ...]:
        """Return a report per condition on curves (m, degree + 1, dof) and their sampled states (n, dof)."""
        alone = [replace(self, conditions=(each,)) for each in self.conditions]
        slacks = self.slacks(q)
        return tuple(
            ConstraintReport(
                each, float(slacks[:, k].min()), int(slacks[:, k].argmin()), bool(alone[k].prove(coefficients).all())
            )
            for k, each in enumerate(self.conditions)
        )

    def project(self, q: Floats, depth: Floats | float = 0.5, exact: float = FORGIVEN) -> tuple[Floats, Bools]:
        """Return states near ``q`` (n, dof) that satisfy all, and which do (n,), within ``exact``.

        Gauss-Newton steps go a share ``depth`` (n,) of the way to the middle of the allowed set; states that satisfy
        all stay unchanged. Continuous joints may pass half a turn.
        """
        return self._project(q, depth, exact, _STEPS)

    def _project(self, q: Floats, depth: Floats | float, exact: float, steps: int) -> tuple[Floats, Bools]:
        return self._native.projected(q, np.full(len(q), depth), exact, steps)


def frame_of(
    robot: Robot, name: str | None, point: Sequence[float] = (0.0, 0.0, 0.0), base: str | None = None
) -> Frame:
    """Return a frame (default: the tool), moved to a point of it (m), in another frame ``base``.

    Raises :class:`RobotError` for an unknown frame, and for one that no planned joint moves in ``base``.
    """
    frame = Frame.tool(with_tool(robot, name), np.array(point))
    if base is None:
        return frame
    frame = replace(frame, base=Frame.tool(with_tool(robot, base)))
    if not frame.reach(robot).any():
        raise RobotError(f"no planned joint moves frame '{name or robot.tool}' in frame '{base}': name two others.")
    return frame


def bind_to_start(conditions: Iterable[Condition], robot: Robot, start: Floats) -> tuple[Condition, ...]:
    """Return conditions with the position or orientation at ``start`` (dof,) if they name none."""
    return tuple(_bind(each, robot, start) if relative_to_start([each]) else each for each in conditions)


def _bind(condition: Condition, robot: Robot, q: Floats) -> Condition:
    point = condition.point if isinstance(condition, OfPoint) else (0.0, 0.0, 0.0)
    (rotation,), (position,) = frame_of(robot, condition.frame, point, condition.base).poses(robot, q[None])
    values = quaternion_of(rotation) if isinstance(condition, OrientationConstraint) else position
    name = "quaternion" if isinstance(condition, OrientationConstraint) else "position"
    return replace(condition, **{name: tuple(round(float(value), 9) + 0.0 for value in values)})  # to be read


def relative_to_start(conditions: Iterable[Condition]) -> tuple[Condition, ...]:
    """Return the constraints that refer to the position or orientation at the start."""
    return tuple(
        each
        for each in conditions
        if (isinstance(each, OrientationConstraint) and each.quaternion is None)
        or (isinstance(each, PositionConstraint) and each.position is None)
    )


def require_bound(conditions: tuple[Condition, ...], robot: Robot) -> None:
    """Raise :class:`PlannerError` for a constraint that refers to a missing start or an unknown frame."""
    for each in relative_to_start(conditions):
        what, numbers = "a position", "x,y,z"
        if isinstance(each, OrientationConstraint):
            what, numbers = "an orientation", "qx,qy,qz,qw"
        raise StateError(f"'{each.text}' must have {what} here, got none: add {numbers} to it.")
    for each in conditions:
        frame_of(robot, each.frame, base=each.base)
