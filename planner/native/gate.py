"""What a controller makes of points, as the compiled gate hands it over."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from planner.base.arrays import Floats
from planner.native.compiled import Judgement


class Chunk(NamedTuple):
    """What joint_trajectory_controller makes of points: pieces (n, degree + 1, dof) between ``times`` (n + 1,) s.

    Until the first point's time a piece leads there from where the robot is, of the highest degree that both know the
    derivatives for. Each takes ``seconds`` (n,). ``knots`` (n + 1, 3, dof): position, velocity and acceleration with
    which the motion comes to each of the times, at the first one those of the robot. ``approach`` (2, dof) is where the
    robot is and by how much the first point, which is at 0 s, is elsewhere; None where the first piece leads there.
    """

    times: Floats
    seconds: Floats
    coefficients: Floats
    knots: Floats
    approach: Floats | None

    @staticmethod
    def of(found: Judgement, made: Floats, points: int, rows: int, dof: int) -> Chunk:
        """The arrays that ``NativeGate.check`` has ``made``, in the order of source/python/gate.hpp."""
        sizes, n = (1 + dof, points + 1, points, points * 2 * rows * dof, 3 * (points + 1) * dof), found.pieces_made
        _, times, seconds, pieces, knots, approach = np.split(made, np.cumsum(sizes))
        return Chunk(
            times[: n + 1],
            seconds[:n],
            pieces.reshape(points, 2 * rows, dof)[:n],
            knots.reshape(points + 1, 3, dof)[: n + 1],
            approach.reshape(2, dof) if found.approached else None,
        )
