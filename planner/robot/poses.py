"""Rigid placements as 4x4 homogeneous matrices, in metres, from rpy or quaternions."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats, frozen, is_placement, length, numbers, placement
from planner.base.errors import ArrayError


def pose(
    position: Sequence[float] | Floats | pin.SE3 = (0.0, 0.0, 0.0),
    rpy: Sequence[float] | None = None,
    quaternion: Sequence[float] | None = None,
) -> Floats:
    """Return the (4, 4) placement at ``position`` (m), rotated by ``rpy`` (rad) or ``quaternion``.

    ``rpy`` turns about fixed axes; ``quaternion`` is [x, y, z, w] and is normalized. A ``pinocchio.SE3`` or an array
    (4, 4) in place of the position is checked and returned. Raises :class:`ArrayError` (a ValueError) for a zero
    quaternion, for values that are not finite and for matrices that are not rigid.
    """
    if is_placement(position):
        if rpy is not None or quaternion is not None:
            raise ArrayError("a pose given as a matrix has its rotation: leave rpy and quaternion out.")
        return frozen(placement("the pose", position))
    matrix = np.eye(4)
    matrix[:3, 3] = numbers("position", position, (3,))
    if rpy is not None:
        matrix[:3, :3] = pin.rpy.rpyToMatrix(numbers("rpy", rpy, (3,)))
    elif quaternion is not None:
        q = numbers("quaternion", quaternion, (4,))
        norm = length(q)
        if not norm > 1e-9:
            raise ArrayError("quaternion must not be zero, got [0, 0, 0, 0]; [0, 0, 0, 1] is the identity")
        matrix[:3, :3] = pin.Quaternion(q / norm).toRotationMatrix()
    return frozen(matrix)


def quaternion_of(rotation: Floats) -> list[float]:
    """Return the unit quaternion [x, y, z, w] of a rotation matrix (3, 3)."""
    return pin.Quaternion(np.array(rotation)).normalized().coeffs().tolist()


def se3(matrix: Floats) -> pin.SE3:
    """Return a (4, 4) placement as Pinocchio's SE3."""
    return pin.SE3(np.array(matrix))
