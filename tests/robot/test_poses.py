"""Placements from rpy and quaternions, against SciPy's rotations."""

import numpy as np
import pinocchio as pin
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


def test_a_matrix_is_a_pose() -> None:
    placement = pin.SE3(Rotation.from_rotvec([0.3, -0.2, 0.9]).as_matrix(), np.array([1.0, 2.0, 3.0]))
    for given in (placement, placement.homogeneous, pose(placement)):
        np.testing.assert_array_equal(pose(given), placement.homogeneous)
    with pytest.raises(ValueError, match="rigid"):
        pose(2.0 * placement.homogeneous)
    with pytest.raises(ValueError, match="leave rpy and quaternion out"):
        pose(placement, rpy=[0.0, 0.0, 1.0])
