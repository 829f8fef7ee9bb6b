"""Batch forward kinematics against Pinocchio, and iiwa14 against KUKA's own DH table."""

import numpy as np
import pinocchio as pin
import pytest

from planner.kinematics.forward import Chain, joint_placements, tool_pose, tool_positions
from planner.robot.poses import pose
from planner.robot.robot import Robot
from tests.worlds import joint_xml, link_xml, load, random_q

UNTURNED = [
    link_xml("a"),
    link_xml("b"),
    link_xml("c"),
    link_xml("d"),
    joint_xml("slide", "a", "b", "prismatic", "0.6 0 0.8", xyz="0.1 0.2 0.3"),
    joint_xml("skew", "b", "c", "revolute", "0.6 0.8 0", xyz="0 0 0.3", limit="-3 3"),
    joint_xml("lift", "c", "d", "prismatic", "0 0 -1", xyz="0 0.1 0"),
]


@pytest.fixture
def odd_robot(urdf_file) -> Robot:
    """Prismatic joints and a skew axis, on a base that is turned."""
    return Robot.load(urdf_file("".join(UNTURNED)), base=pose([1, 2, 3], rpy=[0.3, -0.2, 1.0]))


def assert_as_pinocchio(robot: Robot, q: np.ndarray) -> None:
    rotation, position = joint_placements(Chain.from_arm(robot), q)
    tools = tool_positions(robot, q)
    data = robot.model.createData()
    for k, row in enumerate(q):
        pin.framesForwardKinematics(robot.model, data, row)
        for joint in range(robot.model.njoints):
            np.testing.assert_allclose(rotation[joint, k], data.oMi[joint].rotation, atol=1e-12)
            np.testing.assert_allclose(position[joint, k], data.oMi[joint].translation, atol=1e-12)
        np.testing.assert_allclose(tools[k], data.oMf[robot.tool_id].translation, atol=1e-12)
        np.testing.assert_allclose(tool_pose(robot, row).homogeneous, data.oMf[robot.tool_id].homogeneous, atol=1e-12)


def test_batch_is_pinocchio_for_sliding_and_skew_joints_on_a_turned_base(odd_robot):
    assert odd_robot.prismatic.tolist() == [True, False, True]
    assert_as_pinocchio(odd_robot, random_q(odd_robot, 40))


def denavit_hartenberg(q: np.ndarray) -> np.ndarray:
    """KUKA's table: d = 0.36, 0, 0.42, 0, 0.40, 0, 0.126, a = 0, alpha = -90, 90, 90, -90, -90, 90, 0 degrees."""
    total = np.eye(4)
    table = zip(q, (0.36, 0, 0.42, 0, 0.40, 0, 0.126), (-90, 90, 90, -90, -90, 90, 0), strict=True)
    for theta, d, degrees in table:
        c, s = np.cos(theta), np.sin(theta)
        ca, sa = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        total = total @ np.array([[c, -s * ca, s * sa, 0], [s, c * ca, -c * sa, 0], [0, sa, ca, d], [0, 0, 0, 1]])
    return total


def test_iiwa14_is_the_dh_table():
    robot = load("iiwa14")
    for q in random_q(robot, 100, seed=3):
        np.testing.assert_allclose(tool_pose(robot, q).homogeneous, denavit_hartenberg(q), atol=1e-9)


def test_a_base_moves_everything_with_it():
    base = pose([0.3, -0.2, 0.5], rpy=[0.1, 0.2, 2.0])
    robot, plain = Robot.load("iiwa14", base=base), load("iiwa14")
    for q in random_q(plain, 5):
        np.testing.assert_allclose(tool_pose(robot, q).homogeneous, base @ tool_pose(plain, q).homogeneous, atol=1e-12)
    foot, moved = plain.bodies[0], robot.bodies[0]
    np.testing.assert_allclose(moved.placement, base @ foot.placement, atol=1e-12)
