"""MuJoCo's files as robots: what Pinocchio reads of them, and what is refused or noted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import RobotError
from planner.collision import make_checker
from planner.kinematics.forward import tool_positions
from planner.models.robot import Robot, load_visuals
from planner.models.scene import Scene
from planner.models.shapes import Box, Capsule, Sphere

ARM = """<mujoco model="small"><compiler angle="radian"/><worldbody>
<geom name="floor" type="plane" size="1 1 .1"/>
<body name="base" pos="0 0 0.1"><geom type="box" size=".05 .04 .03"/>
 <body name="upper" pos="0 0 0.1"><joint name="j1" type="hinge" axis="0 0 1"/>
  <geom type="capsule" fromto="0 0 0 0 0 0.3" size="0.03"/>
  <body name="fore" pos="0 0 0.3"><joint name="j2" type="hinge" axis="0 1 0" range="-2 2" limited="true"/>
   <geom type="sphere" size="0.04"/><site name="tip" pos="0 0 0.2"/>
   EXTRA
  </body></body></body></worldbody></mujoco>"""


def arm(folder: Path, extra: str = "", after: str = "") -> Path:
    (folder / "arm.xml").write_text(ARM.replace("EXTRA", extra).replace("</mujoco>", f"{after}</mujoco>"))
    return folder / "arm.xml"


def test_bodies_joints_and_sites(tmp_path: Path) -> None:
    robot = Robot.load(str(arm(tmp_path)), tool="tip")
    assert (robot.name, robot.joints) == ("small", ("j1", "j2"))
    assert robot.continuous.tolist() == [True, False]
    np.testing.assert_allclose([robot.lower, robot.upper], [[-np.pi, -2], [np.pi, 2]])
    assert {body.link: body.shape for body in robot.bodies} == {
        "base": Box((0.1, 0.08, 0.06)),
        "upper": Capsule(0.03, 0.3),
        "fore": Sphere(0.04),
    }
    q = np.array([[0.0, 0.0], [0.3, np.pi / 2]])
    expected = [[0, 0, 0.6], [0.2 * np.cos(0.3), 0.2 * np.sin(0.3), 0.4]]  # from the first body on
    np.testing.assert_allclose(tool_positions(robot, q), expected, atol=1e-12)
    assert make_checker(robot, Scene("none")).first_contact(q) is None
    assert len(load_visuals(robot)) == 3


def test_what_is_not_followed_is_noted(tmp_path: Path) -> None:
    (note,) = Robot.load(
        str(arm(tmp_path, after='<contact><exclude body1="a" body2="b"/></contact>')), tool="tip"
    ).notes
    assert "contact, worldbody/geom, where its first body stands (see --base) are not followed" in note.text


def test_several_robots_are_refused(tmp_path: Path) -> None:
    path = arm(tmp_path)
    path.write_text(path.read_text().replace("</worldbody>", '<body name="other"/></worldbody>'))
    with pytest.raises(RobotError, match="2 bodies in its world, base, other"):
        Robot.load(str(path), tool="tip")


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        ('<geom type="ellipsoid" size="0.1 0.2 0.3"/>', "Ellipsoid is not supported"),
        ('<body name="free"><freejoint name="f"/></body>', "degrees of freedom|cannot be read"),
        ('<body name="ball"><joint name="b" type="ball"/><geom size="0.1"/></body>', "3 degrees of freedom"),
        ('<geom type="mesh" mesh="nothing"/>', "cannot be"),
    ],
)
def test_what_is_refused(tmp_path: Path, extra: str, words: str) -> None:
    with pytest.raises(RobotError, match=words):
        Robot.load(str(arm(tmp_path, extra)), tool="tip")
