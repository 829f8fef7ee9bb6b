"""Conditions on a frame as convex pieces of its pose: half-spaces and balls, which hold between the ends of a chord.

With y = (x, rows of R), the position (m) and the rotation of a frame in one vector of twelve, each is H y >= d or
|B y - c| <= r. An axis R e within an angle a of n is |R e - n| <= 2 sin(a/2), an orientation within a of R0 is
|R - R0| <= 2 sqrt(2) sin(a/2) in the Frobenius norm, for a up to pi, as all these lie on a sphere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.problem.conditions import (
    Condition,
    KeepAxis,
    KeepBox,
    KeepPlane,
    KeepTurn,
    Quaternion,
    Three,
)
from planner.robot.poses import pose

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
        case KeepAxis(axis, direction, angle):
            return [_axis("xyz".index(axis), _unit(direction), angle)]
        case KeepBox(lower, upper):
            return [
                _half(sign * np.eye(3)[k], sign * end, 0.5 * (high - low))
                for k, (low, high) in enumerate(zip(lower, upper, strict=True))
                for sign, end in ((1.0, low), (-1.0, high))
            ]
        case KeepPlane(normal, distance):
            size = math.hypot(*normal)
            return [_half(_unit(normal), distance / size, _DEEP)]
        case KeepTurn(angle):
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
