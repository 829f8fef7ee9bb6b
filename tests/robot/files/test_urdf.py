"""URDF files: iiwa14 against KUKA's data, limits, and refusals."""

import numpy as np
import pinocchio as pin
import pytest

from planner.base.errors import RobotError
from planner.robot.robot import Robot
from tests.refusals import refusal_of
from tests.worlds import joint_xml, link_xml, load


def test_iiwa14_limits():
    robot = load("iiwa14")
    degrees = np.array([170, 120, 170, 120, 170, 120, 175])
    np.testing.assert_allclose(robot.upper, np.radians(degrees), atol=1e-9)
    np.testing.assert_allclose(robot.lower, -np.radians(degrees), atol=1e-9)
    np.testing.assert_allclose(robot.velocity, np.radians([85, 85, 100, 75, 130, 135, 135]), atol=1e-9)
    np.testing.assert_allclose(robot.model.upperEffortLimit, [320, 320, 176, 176, 110, 40, 40])
    assert [robot.model.frames[robot.tool_id].name, robot.tool] == ["flange", "flange"]


def test_continuous_joints_are_one_turn(urdf_file):
    joint = (
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>'
        '<joint name="k" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 1 0"/>'
        '<limit effort="1" velocity="2"/></joint>'
    )
    robot = Robot.load(urdf_file(link_xml("a") + link_xml("b") + link_xml("c") + joint))
    assert robot.continuous.tolist() == [True, True]
    assert robot.lower.tolist() == [-np.pi, -np.pi]
    assert robot.upper.tolist() == [np.pi, np.pi]
    assert robot.velocity.tolist() == [0, 2]


A, B = link_xml("a"), link_xml("b")
J = joint_xml("j", "a", "b")
TWO = '<sphere radius="1"/><sphere radius="2"/>'
LOOP = link_xml("c") + link_xml("d") + joint_xml("k", "c", "d") + joint_xml("l", "d", "c")
REFUSED = {
    "not XML": "<link",
    "floating": A + B + joint_xml("free", "a", "b", "floating"),
    "another geometry": A + link_xml("b", '<cone radius="1"/>') + J,
    "two shapes in one": A + link_xml("b", TWO) + J,
    "a missing mesh": A + link_xml("b", '<mesh filename="package://no/such.stl"/>') + J,
    "no size": A + link_xml("b", '<sphere radius="0"/>') + J,
    "two tips": A + B + link_xml("c") + J + joint_xml("k", "a", "c"),
    "two roots": A + B + link_xml("c") + J,
    "a loose loop": A + B + J + LOOP,
    "no joint": A,
    "limits upside down": A + B + joint_xml("j", "a", "b", limit="1 -1"),
    "limits in degrees": A + B + joint_xml("j", "a", "b", limit="-170 170"),
    "a distant place": A + B + joint_xml("j", "a", "b", xyz="1e300 0 0"),
    "the world's name": A + B + joint_xml("universe", "a", "b"),
    "a misspelt element": link_xml("a", TWO).replace("collision", "colision") + B + J,
    "a misspelt attribute": A + B + J.replace("xyz=", "xzy=", 1),
    "an axis of zero": A + B + J.replace("0 0 1", "0 0 0"),
    "a word for a number": A + B + J.replace("</joint>", '<mimic joint="k" offset="x"/></joint>'),
}


@pytest.mark.parametrize("inside", REFUSED.values(), ids=REFUSED)
def test_refused(urdf_file, inside, capfd):
    """In one sentence: output of the libraries does not reach standard error."""
    path = urdf_file(inside)
    assert refusal_of(lambda: Robot.load(path))
    assert capfd.readouterr() == ("", "")


def test_soft_limits_are_limits(urdf_file):
    soft = '<safety_controller k_velocity="1" soft_lower_limit="-0.5" soft_upper_limit="2"/></joint>'
    inside = link_xml("a") + link_xml("b") + link_xml("c", '<sphere radius="0.1"/>')
    inside += joint_xml("one", "a", "b").replace("</joint>", soft)
    inside += joint_xml("two", "b", "c").replace("</joint>", '<safety_controller k_velocity="1"/></joint>')
    robot = Robot.load(urdf_file(inside))
    assert robot.lower.tolist() == [-0.5, -1.0]
    assert robot.upper.tolist() == [1.0, 1.0]
    with pytest.raises(RobotError, match=r"soft limits of 0\.5 and 0"):
        Robot.load(urdf_file(inside.replace('-0.5" soft_upper_limit="2"', '0.5"')))


def test_a_link_and_a_joint_may_have_the_same_name(urdf_file):
    links = link_xml("a") + link_xml("same", '<sphere radius="0.1"/>') + link_xml("tip") + link_xml("weld")
    joints = joint_xml("j", "a", "same") + joint_xml("same", "same", "tip", xyz="0.3 0 0")
    joints += joint_xml("weld", "tip", "weld", "fixed")
    robot = Robot.load(urdf_file(links + joints), tool="same")  # the joint called same is held
    assert robot.joints == ("j",)
    assert [body.link for body in robot.bodies] == ["same"]
    assert robot.model.frames[robot.tool_id].type == pin.FrameType.BODY
    assert {"a", "same", "tip", "weld"} <= {frame.name for frame in robot.model.frames}
