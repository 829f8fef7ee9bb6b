"""MuJoCo's files as robots: what Pinocchio reads of them, and what is refused or noted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from planner.base.arrays import Floats
from planner.base.errors import RobotError
from planner.collision import make_checker
from planner.kinematics.forward import tool_positions
from planner.models.poses import pose
from planner.models.robot import Robot, load_visuals
from planner.models.scene import Scene
from planner.models.shapes import Box, Capsule, Mesh, Sphere

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
    more = '<contact><exclude body1="a" body2="b"/></contact><keyframe><key name="home" qpos="1 1"/></keyframe>'
    (note,) = Robot.load(str(arm(tmp_path, after=more)), tool="tip").notes
    assert "contact, keyframe, worldbody/geom, where its first body stands (give it a base) are not" in note.text


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
        ('<frame pos="0 0 1"><geom size="0.1"/></frame>', "holds <frame>"),
        ('<replicate count="2" offset="0 0 1"><geom size="0.1"/></replicate>', "holds <replicate>"),
        ('<include file="hand.xml"/>', "holds <include>"),
        ('<geom size="0.1" pos="1 0"/>', "pos='1 0' of <geom> is not 3 numbers"),
        ('<geom size="0.1" pos="1,0,0"/>', "is not 3 numbers"),
        ('<geom size="0.1" pos="0 nan 0"/>', "is not 3 numbers"),
        ('<body name="x" pos="0 0 1e9"/>', "pos='0 0 1e9' of <body> 'x' is not 3 numbers of at most 10000"),
        ('<joint name="j3" axis="0 0 0"/>', "axis='0 0 0' of <joint> 'j3' has no direction"),
        ('<joint name="j1" axis="1 0 0"/>', "two joint elements called 'j1'"),
        ('<geom type="box" size="0.1"/>', "of type box with size '0.1': give 3 above 0"),
        ('<geom type="capsule" fromto="0 0 0 0 0 1"/>', "of type capsule with no size: give 1 above 0"),
        ('<geom type="sphere" size="-1"/>', "of type sphere with size '-1'"),
        ('<geom class="nobody" size="0.1"/>', "no default of class 'nobody'"),
        ('<gom size="0.1"/>', "unknown element 'gom' .did you mean 'geom'"),
        ('<joint name="j3" axis="1 0 0" ref="0.5"/>', "count from a ref"),
        ("</body></body></body></worldbody><worldbody><body><body><body>", "not one worldbody"),
    ],
)
def test_what_is_refused(tmp_path: Path, extra: str, words: str) -> None:
    with pytest.raises(RobotError, match=words):
        Robot.load(str(arm(tmp_path, extra)), tool="tip")


SIDEWAYS = '<default class="sideways"><geom euler="0 0 1.5707963267948966"/></default>'
BOX = '<geom type="box" size="0.1 0.2 0.3" pos="0 0 0.7" quat="0 1 0 0"/>'
PAD = f'<default class="pad">{BOX}<site pos="0 0 0.5"/>{SIDEWAYS}</default>'
DEFAULTS = f'<default><mesh scale="0.5 0.5 2"/>{PAD}</default>'
HELD = """<body name="held" childclass="pad">
  <geom name="a"/><geom name="b" class="sideways"/><geom name="c" pos="0 0 0"/><site name="end"/>
  <geom name="e" type="capsule" size="0.1" fromto="0 0 0 0 0 1"/>
  </body><geom name="d" class="main" type="mesh" mesh="part"/>"""


def test_what_defaults_say_is_followed(tmp_path: Path) -> None:
    """Places, orientations and scales, which Pinocchio does not follow by itself."""
    triangles = [[(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 0, 0), (0, 0, 1), (1, 0, 0)]]
    corners = [" ".join(f"vertex {x} {y} {z}" for x, y, z in triangle) for triangle in triangles]
    facets = [f"facet normal 0 0 0 outer loop {three} endloop endfacet" for three in corners]
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "part.stl").write_text("\n".join(["solid s", *facets, "endsolid s"]))
    path = arm(tmp_path, HELD, f'{DEFAULTS}<asset><mesh name="part" file="part.stl"/></asset>')
    path.write_text(path.read_text().replace('"radian"', '"radian" meshdir="parts"'))
    robot = Robot.load(str(path), tool="end")
    bodies = {body.name: body for body in robot.bodies}
    assert bodies["a"].shape == bodies["b"].shape == bodies["c"].shape == Box((0.2, 0.4, 0.6))
    np.testing.assert_allclose(bodies["a"].placement, np.diag([1, -1, -1, 1]) + np.outer([0, 0, 0.7, 0], [0, 0, 0, 1]))
    np.testing.assert_allclose(bodies["b"].placement[:3, :3], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)
    np.testing.assert_allclose([bodies[name].placement[2, 3] for name in "bc"], [0.7, 0.0])
    assert bodies["e"].shape == Capsule(0.1, 1.0)
    np.testing.assert_allclose(bodies["e"].placement, np.eye(4) + np.outer([0, 0, 0.5, 0], [0, 0, 0, 1]))
    part = bodies["d"].shape
    assert isinstance(part, Mesh)
    np.testing.assert_allclose(np.ptp(part.vertices, axis=0), [0.5, 0.5, 2])
    np.testing.assert_allclose(tool_positions(robot, np.zeros((1, 2))), [[0, 0, 0.9]], atol=1e-12)


def test_metres_of_sliding_joints_are_no_degrees(tmp_path: Path) -> None:
    free = '<body name="q"><joint name="q" axis="0 1 0"/><geom size="0.1"/></body>'
    path = arm(tmp_path, f'<body name="slider"><joint name="s" class="s"/><geom size="0.1"/>{free}</body>')
    text = path.read_text().replace('<compiler angle="radian"/>', "")
    path.write_text(
        text.replace(
            "<worldbody>",
            '<default><default class="s"><joint type="slide" range="-1 2"/></default></default><worldbody>',
        )
    )
    robot = Robot.load(str(path), tool="slider")
    np.testing.assert_allclose([robot.lower, robot.upper], [[-np.pi, -np.radians(2), -1], [np.pi, np.radians(2), 2]])


@pytest.mark.parametrize(
    ("compiler", "joint", "turns_freely"),
    [
        ("", 'range="-2 2" limited="true"', False),
        ("", 'range="-2 2" limited="auto"', False),
        ("", 'range="-2 2"', False),
        ("", 'range="-2 2" limited="false"', True),
        ("", 'limited="false"', True),
        ('autolimits="false"', 'range="-2 2"', True),
        ('autolimits="false"', 'range="-2 2" limited="true"', False),
    ],
)
def test_a_range_counts_where_it_limits(tmp_path: Path, compiler: str, joint: str, turns_freely: bool) -> None:
    path = arm(tmp_path)
    text = path.read_text().replace('angle="radian"', f'angle="radian" {compiler}')
    path.write_text(text.replace('range="-2 2" limited="true"', joint))
    robot = Robot.load(str(path), tool="tip")
    assert robot.continuous.tolist() == [True, turns_freely]
    np.testing.assert_allclose(robot.upper[1], np.pi if turns_freely else 2.0)


@pytest.mark.parametrize("joint", ['range="-2 2" limited="maybe"', 'limited="true"'])
def test_limits_that_make_no_sense_are_refused(tmp_path: Path, joint: str) -> None:
    path = arm(tmp_path)
    path.write_text(path.read_text().replace('range="-2 2" limited="true"', joint))
    with pytest.raises(RobotError, match=r"limited=.*give true, false, auto, and a range"):
        Robot.load(str(path), tool="tip")


WELDED = """<mujoco><compiler angle="radian"/><worldbody><body name="base"><geom size="0.02"/>
<body name="arm"><joint name="j" axis="0 0 1" pos="0.1 0.2 0" range="-2 2"/><geom size="0.02"/>
 <site name="own" pos="1 0 0"/>
 <body name="flange" pos="0.3 0 0" euler="0 0 0.5"><geom size="0.02"/><site name="near" pos="0 0.1 0"/>
  <body name="hand" pos="0.4 0 0"><geom size="0.02"/><site name="tip" pos="0 0 0.1" euler="1 0 0"/>
   <body name="finger" pos="0.1 0 0"><joint name="k" axis="0 0 1" pos="0 0.1 0" range="-2 2"/><geom size="0.02"/>
    <body name="pad" pos="0 0.1 0"><geom size="0.02"/><site name="end" pos="0.1 0 0"/>
</body></body></body></body></body></body></worldbody></mujoco>"""


@pytest.mark.parametrize("tool", ["own", "near", "tip", "end"])
def test_sites_are_where_their_bodies_are(tmp_path: Path, tool: str) -> None:
    """Those of a body without joints stood where the body above had its joint: with it off the origin, or two deep."""
    (tmp_path / "welded.xml").write_text(WELDED)
    robot = Robot.load(str(tmp_path / "welded.xml"), tool="tip")
    values = dict(zip(robot.joints, (0.7, -0.4), strict=False))
    arm = _turned(values["j"], (0.1, 0.2, 0))
    flange = arm @ pose([0.3, 0, 0], rpy=[0, 0, 0.5])
    hand = flange @ pose([0.4, 0, 0])
    pad = hand @ pose([0.1, 0, 0]) @ _turned(values.get("k", 0.0), (0, 0.1, 0)) @ pose([0, 0.1, 0])
    where = {
        "own": arm @ pose([1, 0, 0]),
        "near": flange @ pose([0, 0.1, 0]),
        "tip": hand @ pose([0, 0, 0.1], rpy=[1, 0, 0]),
        "end": pad @ pose([0.1, 0, 0]),
    }
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, np.array(list(values.values())))
    there = data.oMf[robot.model.getFrameId(tool)].homogeneous
    np.testing.assert_allclose(there, where[tool], rtol=0, atol=1e-12)


def _turned(angle: float, about: tuple[float, float, float]) -> Floats:
    """A turn about the z-axis through a point."""
    return pose(about, rpy=[0, 0, angle]) @ pose([-x for x in about])
