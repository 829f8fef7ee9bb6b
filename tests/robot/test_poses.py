"""Placements from rpy and quaternions, against SciPy's rotations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from planner.robot.poses import pose, se3


@pytest.mark.parametrize("seed", range(5))
def test_rotations_are_scipys(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rpy, quaternion, at = (
        rng.uniform(-3, 3, 3).tolist(),
        (5.0 * rng.normal(size=4)).tolist(),
        rng.normal(size=3).tolist(),
    )
    turned = pose(at, rpy=rpy)
    np.testing.assert_allclose(turned[:3, :3], Rotation.from_euler("xyz", rpy).as_matrix(), atol=1e-12)
    np.testing.assert_array_equal(turned[:3, 3], at)
    found = pose(at, quaternion=quaternion)
    np.testing.assert_allclose(found[:3, :3], Rotation.from_quat(quaternion).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(se3(found).homogeneous, found, atol=1e-12)


def test_a_quaternion_of_zero_has_no_direction() -> None:
    with pytest.raises(ValueError, match="zero length"):
        pose(quaternion=[0.0, 0.0, 0.0, 0.0])
