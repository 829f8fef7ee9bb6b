"""All that the motions of one robot keep: seen in states, proven on whole curves, and states brought to keep it.

Conditions become convex pieces of a frame's pose: half-spaces and balls, which hold between the ends of a chord. With
y = (x, rows of R), the position (m) and the rotation of a frame in one vector of twelve, each is H y >= d or
|B y - c| <= r. An axis R e within an angle a of n is |R e - n| <= 2 sin(a/2), an orientation within a of R0 is
|R - R0| <= 2 sqrt(2) sin(a/2) in the Frobenius norm, for a up to pi, as all these lie on a sphere.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.errors import StateError
from planner.constraints.tool_bound import Frame, ToolBound
from planner.kinematics.forward import Chain
from planner.native.compiled import NativeKeeping
from planner.problem.conditions import (
    AxisConstraint,
    BoxConstraint,
    Condition,
    OfPoint,
    OrientationConstraint,
    PlaneConstraint,
    Quaternion,
    Three,
)
from planner.robot.poses import pose, quaternion_of
from planner.robot.robot import Robot, with_tool

FORGIVEN = 1e-9  # rad (m): beyond a condition by what was printed and read back
_STEPS = 30  # of a projection
_FINEST = 0.1 * FORGIVEN  # rad (m): pieces that leave their chords by less are not halved

_DEEP = 5e-3  # m: how far into a half-space without another side states are projected


@dataclass(frozen=True, eq=False)
class Piece:
    """``rows`` (k, 12) of y: one row . y >= ``limit``, or of a ``ball`` |rows y - ``centre`` (k,)| <= ``limit``.

    Its slack changes by ``per_metre`` of the position at most, and with the rotation by ``per_turn`` of the length by
    which a unit vector of it changes. ``depth`` is how much more a half-space may have; ``across`` is the distance of
    angles at half a turn, so that one of d is 2 asin(d / across).
    """

    rows: Floats
    centre: Floats
    limit: float
    ball: bool
    per_metre: float = 0.0
    per_turn: float = 0.0
    depth: float = 0.0
    across: float = 0.0

    def spare(self, slack: Floats) -> Floats:
        """A slack in m, or rad."""
        if not self.ball:
            return slack
        ends = np.clip(np.stack([np.full_like(slack, self.limit), self.limit - slack]) / self.across, 0.0, 1.0)
        return 2.0 * (np.arcsin(ends[0]) - np.arcsin(ends[1]))


def _half(normal: Floats, limit: float, depth: float) -> Piece:
    row = np.append(normal, np.zeros(9))
    return Piece(frozen(row[None]), frozen([0.0]), limit, False, float(np.linalg.norm(normal)), depth=depth)


def pieces_of(condition: Condition) -> list[Piece]:
    """The convex pieces that make up a condition; one of a turn has its quaternion."""
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
        case OrientationConstraint(angle):
            return [_turn(_matrix(condition.quaternion), angle)]
    raise TypeError(f"no pieces make up a {type(condition).__name__}")


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
class PathConstraints:
    """Bound ``conditions`` on frames of a ``robot``, of which none may be broken.

        constraints = PathConstraints(robot, parse_constraints("axis:z,0,0,1,0.1"))
        constraints.holds(q)                          # (n,) in states (n, dof)
        constraints.proven(coefficients)              # (m,) on whole curves (m, degree + 1, dof)

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


def bind_orientations(conditions: Iterable[Condition], robot: Robot, start: Floats) -> tuple[Condition, ...]:
    """Conditions with the orientation that their frames have at the ``start`` (dof,), where they name none."""
    return tuple(
        replace(each, quaternion=_orientation(robot, each.frame, start)) if without_orientation([each]) else each
        for each in conditions
    )


def _orientation(robot: Robot, frame: str | None, q: Floats) -> Quaternion:
    rotation, _ = frame_of(robot, frame).poses(robot, q[None])
    x, y, z, w = (round(float(value), 9) for value in quaternion_of(rotation[0]))  # to be read
    return x, y, z, w


def without_orientation(conditions: Iterable[Condition]) -> tuple[Condition, ...]:
    """Those that mean the orientation at the start."""
    return tuple(each for each in conditions if isinstance(each, OrientationConstraint) and each.quaternion is None)


def require_orientations(conditions: tuple[Condition, ...], robot: Robot) -> None:
    """Raise :class:`PlannerError` for what means a start where there is none, or a frame that is not there."""
    for each in without_orientation(conditions):
        raise StateError(f"'{each.text}' means the orientation at a start, and here is none: add qx,qy,qz,qw to it.")
    for each in conditions:
        frame_of(robot, each.frame)
