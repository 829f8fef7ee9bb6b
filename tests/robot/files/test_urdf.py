"""iiwa14's URDF against KUKA's data, and what reading a URDF does, refuses and says."""

import numpy as np
import pinocchio as pin
import pytest

from planner.base.errors import RobotError
from planner.robot.robot import Robot
from planner.robot.shapes import Capsule, Cylinder
from tests.worlds import joint_xml, link_xml, load

# link: end points of the capsule's axis in the upright link frame, radius (iiwa14.md)
CAPSULES = {
    1: [((0, -0.030, 0.204), (0, 0, 0.029), 0.092)],
    2: [((0, 0, 0.140), (0, 0.039, -0.001), 0.095)],
    3: [((0, 0.040, 0.217), (0, 0, 0.039), 0.080)],
    4: [((0, -0.041, -0.001), (0, 0, 0.144), 0.081)],
    5: [((0, -0.024, 0.060), (0, 0, 0.024), 0.076), ((0, -0.064, 0.216), (0, -0.065, 0.144), 0.055)],
    6: [((0, 0, 0.022), (0, 0, -0.016), 0.080)],
}
CYLINDERS = {0: ((-0.0151, 0, 0.07875), 0.1575, 0.1366), 7: ((0, 0, 0.0176), 0.0549, 0.0523)}
ORIGINS = (0, 0.1575, 0.36, 0.5645, 0.78, 0.9645, 1.18, 1.261)


@pytest.fixture(scope="module")
def upright():
    """{link number: [(shape, placement in the upright link frame)]} of iiwa14."""
    robot = load("iiwa14")
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, np.zeros(7))
    found: dict[int, list] = {}
    for item in robot.bodies:
        number = int(item.link[-1])
        world = data.oMi[item.joint].homogeneous @ item.placement
        world[2, 3] -= ORIGINS[number]
        found.setdefault(number, []).append((item.shape, world))
    return found


@pytest.mark.parametrize("number", CAPSULES)
def test_iiwa14_capsules(upright, number):
    assert len(upright[number]) == len(CAPSULES[number])
    for shape, place in upright[number]:
        assert isinstance(shape, Capsule)
        ends = [place[:3, 3] + side * 0.5 * shape.length * place[:3, 2] for side in (1, -1)]
        fits = [
            (p, q, r)
            for a, b, r in CAPSULES[number]
            for p, q in ((a, b), (b, a))
            if np.allclose(ends, [p, q], atol=1e-9) and shape.radius == pytest.approx(r, abs=1e-12)
        ]
        assert fits, f"no capsule of the table lies at {ends}"


@pytest.mark.parametrize("number", CYLINDERS)
def test_iiwa14_cylinders(upright, number):
    ((shape, place),) = upright[number]
    centre, length, radius = CYLINDERS[number]
    assert shape == Cylinder(radius, length)
    np.testing.assert_allclose(place[:3, 3], centre, atol=1e-12)
    np.testing.assert_allclose(np.abs(place[:3, 2]), [0, 0, 1], atol=1e-12)


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
    "not XML": ("<link", "well-formed"),
    "floating": (A + B + joint_xml("free", "a", "b", "floating"), "'free' of .* has 6 degrees of freedom"),
    "another geometry": (A + link_xml("b", '<cone radius="1"/>') + J, "0 of the 1 collision geometries"),
    "two shapes in one": (A + link_xml("b", TWO) + J, "1 of the 2 collision geometries"),
    "a missing mesh": (A + link_xml("b", '<mesh filename="package://no/such.stl"/>') + J, "such.stl.*ROS_PACKAGE_PATH"),
    "a scale": (A + link_xml("b", '<mesh filename="package://no/such.stl" scale="1 x 1"/>') + J, "such.stl"),
    "no size": (A + link_xml("b", '<sphere radius="0"/>') + J, "Sphere.radius"),
    "two tips": (A + B + link_xml("c") + J + joint_xml("k", "a", "c"), "2 tips: name one as its tool; tips are b, c"),
    "two roots": (A + B + link_xml("c") + J, "Two root links found"),
    "a loose loop": (A + B + J + LOOP, "links c, d of .* hang on no root"),
    "no joint": (A, "no movable joint"),
    "limits upside down": (A + B + joint_xml("j", "a", "b", limit="1 -1"), r"limits \[1, -1\]: give it finite"),
    "limits in degrees": (A + B + joint_xml("j", "a", "b", limit="-170 170"), "degrees"),
    "a distant place": (A + B + joint_xml("j", "a", "b", xyz="1e300 0 0"), "beyond 10000 m"),
    "the world's name": (A + B + joint_xml("universe", "a", "b"), "'universe'"),
    "a misspelt element": (
        link_xml("a", TWO).replace("collision", "colision") + B + J,
        r"'colision' \(did you mean 'collision'\?\)",
    ),
    "a misspelt attribute": (A + B + J.replace("xyz=", "xzy=", 1), r"did you mean 'xyz'\?"),
    "an axis of zero": (A + B + J.replace("0 0 1", "0 0 0"), "has no direction"),
    "a word for a number": (
        A + B + J.replace("</joint>", '<mimic joint="k" offset="x"/></joint>'),
        "offset of <mimic>",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(urdf_file, case, capfd):
    """In one sentence: what the libraries print does not reach standard error."""
    inside, part = REFUSED[case]
    path = urdf_file(inside)
    with pytest.raises(RobotError, match=part) as caught:
        Robot.load(path)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith(".")
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
