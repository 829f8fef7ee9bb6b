"""Joints that mimic others: tools and held objects follow, whatever the order of leaders."""

from collections.abc import Callable

import numpy as np

from planner.kinematics.forward import Chain, joint_placements, tool_positions
from planner.robot.files.robot_files import JointChoice
from planner.robot.robot import Robot, with_carried, with_tool
from planner.robot.shapes import Carried, Sphere
from tests.refusals import refusal_of
from tests.worlds import joint_xml, link_xml

CHAIN = "".join(map(link_xml, ("base", "upper", "fore", "flange", "tcp"))) + (
    joint_xml("turn", "base", "upper", xyz="0 0 0.5") + joint_xml("bend", "upper", "fore", axis="0 1 0", xyz="0 0 0.5")
)
TCP = '<joint name="hold" type="fixed"><parent link="flange"/><child link="tcp"/><origin xyz="0 0 0.3"/></joint>'


def follows(leader: str = "bend") -> str:
    joint = joint_xml("follow", "fore", "flange", axis="0 1 0", xyz="0 0 0.2")
    return CHAIN + joint.replace("</joint>", f'<mimic joint="{leader}"/></joint>') + TCP


def test_a_mimic_joint_moves_tools_and_held_objects(urdf_file: Callable[..., str]) -> None:
    """Nothing that collides hangs on it: it was held where it is 0."""
    path, planned = urdf_file(follows()), JointChoice(joints=("turn", "bend"))
    q = np.array([[0.3, 0.4]])
    there = [0.2 * np.sin(0.4) + 0.3 * np.sin(0.8), 0.0, 1.0 + 0.2 * np.cos(0.4) + 0.3 * np.cos(0.8)]
    turned = [np.cos(0.3) * there[0], np.sin(0.3) * there[0], there[2]]
    robot = Robot.load(path, tool="fore", choice=planned)
    for moved in (Robot.load(path, tool="tcp", choice=planned), Robot.load(path, tool="tcp"), with_tool(robot, "tcp")):
        assert moved.joints == ("turn", "bend")
        np.testing.assert_allclose(tool_positions(moved, q)[0], turned, atol=1e-15)
    holding = with_carried(robot, [Carried("tcp", "cup", Sphere(0.03), np.eye(4))])
    rotation, position = joint_placements(Chain.from_arm(holding), q)
    (cup,) = holding.carried
    at = position[cup.joint, 0] + rotation[cup.joint, 0] @ cup.placement[:3, 3]
    np.testing.assert_allclose(at, turned, atol=1e-15)
    assert "'follow' mimics 'bend', which is planned, so it cannot be held" in refusal_of(
        lambda: Robot.load(path, tool="tcp", choice=planned, fixed_joints={"follow": 0.0})
    )
    led = Robot.load(path, tool="tcp", choice=JointChoice(joints=("turn",)), fixed_joints={"bend": 0.5})
    assert led.fixed_joints == {"bend": 0.5, "follow": 0.5}
