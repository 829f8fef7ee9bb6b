"""Conditions on a frame as convex pieces of its pose: half-spaces and balls, which hold between the ends of a chord.

With y = (x, rows of R), the position (m) and the rotation of a frame in one vector of twelve, each is H y >= d or
|B y - c| <= r. An axis R e within an angle a of n is |R e - n| <= 2 sin(a/2), an orientation within a of R0 is
|R - R0| <= 2 sqrt(2) sin(a/2) in the Frobenius norm, for a up to pi, as all these lie on a sphere. With M = R0ᵀ R the
intrinsic angles about x, y and z are atan2(-M12, M22), asin M02 and atan2(-M01, M00), and that they keep to tolerances
up to pi / 2 is linear in M.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.models.poses import pose
from planner.problem.conditions import (
    Condition,
    KeepAxis,
    KeepBox,
    KeepEuler,
    KeepPlane,
    KeepRotationVector,
    KeepSphere,
    KeepTurn,
    Quaternion,
    Three,
)

_DEEP = 5e-3  # m: how far into a half-space without another side states are projected
_RIGHT = 0.5 * math.pi


@dataclass(frozen=True, eq=False)
class Piece:
    """``rows`` (k, 12) of y: one row . y >= ``limit``, or of a ``ball`` |rows y - ``centre`` (k,)| <= ``limit``.

    What it has to spare changes by ``per_metre`` of the position at most, and with the rotation by ``per_turn`` of the
    length of what a unit vector of it changes: <A, D> <= |A|_nuclear |D|_2. ``depth`` is how much more a half-space may
    have; ``across`` of angles in a ball the distance at half a turn, so that one of d is 2 asin(d / across).
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
        if self.per_metre:
            return slack
        if not self.ball:
            return np.arcsin(np.clip(slack, -1.0, 1.0))
        ends = np.clip(np.stack([np.full_like(slack, self.limit), self.limit - slack]) / self.across, 0.0, 1.0)
        return 2.0 * (np.arcsin(ends[0]) - np.arcsin(ends[1]))


def _half(row: Floats, limit: float, depth: float) -> Piece:
    per_turn = float(np.linalg.svd(row[3:].reshape(3, 3), compute_uv=False).sum())
    return Piece(frozen(row[None]), frozen([0.0]), limit, False, float(np.linalg.norm(row[:3])), per_turn, depth)


def pieces_of(condition: Condition) -> list[Piece]:
    """The convex pieces of a condition that is bound: one of a turn has its quaternion.

    They are the condition itself, but for two: angles of ``euler`` that are neither free nor within pi / 2 are kept to
    that, and of ``rotvec`` a convex part is kept. Where no component of the rotation vector v is free, that part is
    |v| <= t and |v_i| sin|v| / |v| <= t_i sin t / t with t the length of the tolerances, as sin t / t falls. Where one
    is free, from pi on, it is the cone of its axis in which sin(half its angle) is a pi-th of the least of the others.
    """
    match condition:
        case KeepAxis(axis, direction, angle):
            return [_axis("xyz".index(axis), _unit(direction), angle)]
        case KeepBox(lower, upper):
            return [
                _half(sign * np.eye(12)[k], sign * end, 0.5 * (high - low))
                for k, (low, high) in enumerate(zip(lower, upper, strict=True))
                for sign, end in ((1.0, low), (-1.0, high))
            ]
        case KeepSphere(centre, radius):
            return [Piece(frozen(np.eye(12)[:3]), frozen(centre), radius, True, per_metre=1.0)]
        case KeepPlane(normal, distance):
            size = math.hypot(*normal)
            return [_half(np.append(_unit(normal), np.zeros(9)), distance / size, _DEEP)]
        case KeepTurn(angle):
            return [_turn(_matrix(condition.quaternion), angle)]
        case KeepRotationVector(tolerances):
            return _rotation_vector(_matrix(condition.quaternion), tolerances)
        case KeepEuler(tolerances):
            return _euler(_matrix(condition.quaternion), tolerances)
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


def _entry(matrix: Floats, i: int, j: int) -> Floats:
    """The row (12,) that reads M_ij, M = R0ᵀ R."""
    row = np.zeros(12)
    row[[3 + 3 * k + j for k in range(3)]] = matrix[:, i]
    return row


def _euler(matrix: Floats, tolerances: Three) -> list[Piece]:
    x, y, z = tolerances
    made: list[Piece] = []
    for tolerance, level, across in ((x, (2, 2), (1, 2)), (z, (0, 0), (0, 1))):
        if tolerance < math.pi:
            angle = min(tolerance, _RIGHT)
            along, aside = (math.sin(angle) * _entry(matrix, *level), math.cos(angle) * _entry(matrix, *across))
            made += [_half(along + sign * aside, 0.0, math.sin(angle)) for sign in (1.0, -1.0)]
    if y < _RIGHT:
        row = _entry(matrix, 0, 2)
        made += [_half(sign * row, -math.sin(y), math.sin(y)) for sign in (1.0, -1.0)]
    # what follows from these shows states that are far off the way
    for k, others in ((2, (x, y)), (0, (y, z))):
        if sum(others) < math.pi:
            made.append(_axis(k, matrix[:, k], sum(others)))
    return made


def _rotation_vector(matrix: Floats, tolerances: Three) -> list[Piece]:
    free = [k for k, tolerance in enumerate(tolerances) if tolerance >= math.pi]
    bounded = [tolerance for tolerance in tolerances if tolerance < math.pi]
    if not bounded:
        return []
    if free:
        return [_axis(free[0], matrix[:, free[0]], 2.0 * math.asin(min(bounded) / math.pi))]
    length = min(math.hypot(*tolerances), _RIGHT)
    made: list[Piece] = [_turn(matrix, length)]
    for k, tolerance in enumerate(tolerances):
        i, j = (k + 1) % 3, (k + 2) % 3
        row = 0.5 * (_entry(matrix, j, i) - _entry(matrix, i, j))
        least = tolerance * math.sin(length) / length if length else 0.0
        made += [_half(sign * row, -least, least) for sign in (1.0, -1.0)]
    return made
