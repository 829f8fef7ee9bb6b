"""A URDF is looked through before a native parser sees it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable

import pytest

from planner.robot.files.packages import example_robot_data
from planner.robot.files.urdf_rules import require_sane_urdf
from planner.robot.robot import Robot
from tests.cli.test_bad_files import A, B, C, J
from tests.refusals import refusal_of
from tests.worlds import joint_xml, link_xml

ROBOTS = {
    "a joint called universe": (A + B + joint_xml("universe", "a", "b"), "'universe'"),
    "two joints of one name": (A + B + C + J + joint_xml("j", "b", "c"), "'j' is not unique"),
    "a loop": (A + B + J + joint_xml("k", "b", "a"), "loop"),
    "two parents": (A + B + C + J + joint_xml("k", "c", "b"), "child of two joints"),
    "an axis without direction": (A + B + joint_xml("j", "a", "b", axis="0 0 0"), "no direction"),
    "an origin of 1e300": (A + B + joint_xml("j", "a", "b", xyz="1e300 0 0"), "beyond 10000"),
    "a cylinder of radius 0": (link_xml("a", '<cylinder radius="0" length="1"/>') + B + J, "must be a size"),
    "a mesh scaled to nothing": (link_xml("a", '<mesh filename="x.stl" scale="0 0 0"/>') + B + J, "must not be 0"),
    "a collision without geometry": (A + '<link name="b"><collision/></link>' + J, "1 of the 2 collision geometries"),
    "a collision misspelt": (A + B.replace("collision", "colision") + J, "'colision' (did you mean 'collision'?)"),
    "a limit's uper end": (A + B + J.replace("upper", "uper"), "'uper' (did you mean 'upper'?)"),
    "a quaternion misspelt": (A + B + J.replace("<origin ", '<origin quat="0 0 0 1" '), "'quat'"),
    "a quaternion of 0": (A + B + J.replace("<origin ", '<origin quat_xyzw="0 0 0 0" '), "must not be 0"),
    "two roots": (A + B + C + J, "Two root links found"),
    "an unknown parent": (A + B + joint_xml("j", "nowhere", "b"), "parent link [nowhere]"),
    "two shapes in one geometry": (
        A + B.replace("</geometry>", '<box size="1 1 1"/></geometry>') + J,
        "<geometry> holds sphere, box",
    ),
    "two axes": (A + B + J.replace("</joint>", '<axis xyz="0 1 0"/></joint>'), "only the first"),
    "a link in a link": (A + B.replace("</link>", C + "</link>") + J, "<link> holds 'link'"),
    "limits in degrees": (A + B + joint_xml("j", "a", "b", limit="-170 170"), "degrees?"),
    "limits of 1e308": (A + B + joint_xml("j", "a", "b", "prismatic", limit="-1e308 1e308"), "real ones"),
    "a joint of no known kind": (A + B + joint_xml("j", "a", "b", "wobbly"), "no known type [wobbly]"),
}


@pytest.mark.parametrize("name", ROBOTS)
def test_robots(name: str, urdf_file: Callable[..., str], capfd: pytest.CaptureFixture[str]) -> None:
    """In our own words: urdfdom's do not reach standard error."""
    inside, part = ROBOTS[name]
    path = urdf_file(inside)
    assert part in refusal_of(lambda: Robot.load(path))
    assert capfd.readouterr() == ("", "")


def test_no_published_urdf_is_misread() -> None:
    """Of 60 robots, those with attributes and elements of other programs included."""
    files = sorted(example_robot_data().rglob("*.urdf"))
    assert len(files) > 50
    for path in files:
        require_sane_urdf(ET.parse(path).getroot(), path)
