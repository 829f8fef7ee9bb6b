"""MuJoCo's files as robots: their bodies, sites and geoms stand where MuJoCo puts them."""

from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from planner.base.arrays import Floats
from planner.collision import make_checker
from planner.kinematics.forward import tool_positions
from planner.robot.files import urdf
from planner.robot.files.mjcf import _name
from planner.robot.files.urdf_geometry import read_geometry, shape_of
from planner.robot.robot import Robot, load_visuals
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.trajectory.limits import MotionLimits
from tests.refusals import refusal_of
from tests.robot.files.random_mjcf import random_mjcf

ARM = """<mujoco model="small"><compiler angle="radian"/><worldbody>
<geom name="floor" type="plane" size="1 1 .1"/>
<body name="base" pos="0 0 0.1"><geom type="box" size=".05 .04 .03"/>
 <body name="upper" pos="0 0 0.1"><joint name="j1" type="hinge" axis="0 0 1"/>
  <geom type="capsule" fromto="0 0 0 0 0 0.3" size="0.03"/>
  <body name="fore" pos="0 0 0.3"><joint name="j2" type="hinge" axis="0 1 0" range="-2 2"/>
   <geom type="sphere" size="0.04"/><site name="tip" pos="0 0 0.2"/>
   EXTRA
  </body></body></body></worldbody></mujoco>"""


def arm(folder: Path, extra: str = "", after: str = "", replaced: tuple[str, str] = ("", "")) -> str:
    text = ARM.replace("EXTRA", extra).replace("</mujoco>", f"{after}</mujoco>")
    (folder / "arm.xml").write_text(text.replace(*replaced) if replaced[0] else text)
    return str(folder / "arm.xml")


@pytest.fixture
def quiet() -> Iterator[None]:
    """MuJoCo's warnings on masses go nowhere."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    yield
    mujoco.set_mju_user_warning(before)


# MuJoCo's own placements


@pytest.mark.usefixtures("quiet")
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("first", range(0, 60, 20))
def test_all_stands_where_mujoco_puts_it(tmp_path: Path, first: int) -> None:
    for seed in range(first, first + 20):
        rng = np.random.default_rng(seed)
        (tmp_path / "robot.xml").write_text(random_mjcf(rng))
        require_same(tmp_path / "robot.xml", rng)


def require_same(path: Path, rng: np.random.Generator) -> None:
    theirs = mujoco.MjModel.from_xml_path(str(path))
    there = mujoco.MjData(theirs)
    there.qpos[:] = rng.uniform(-2, 2, theirs.nq)
    mujoco.mj_kinematics(theirs, there)  # the part of mj_forward that places
    description = urdf.read_description(path)
    model = urdf.build_model(description)
    q = np.zeros(theirs.nq)
    for k in range(theirs.njnt):
        q[model.joints[model.getJointId(_name(theirs.joint(k)))].idx_q] = there.qpos[theirs.jnt_qposadr[k]]
    here = model.createData()
    pin.framesForwardKinematics(model, here, q)
    names = [_name(theirs.body(k)) for k in range(theirs.nbody)] + [_name(theirs.site(k)) for k in range(theirs.nsite)]
    frames = [here.oMf[urdf.frame_id(model, name)] for name in names]
    require_places(frames, [there.xpos, there.site_xpos], [there.xmat, there.site_xmat])
    for kind in ("collision", "visual"):
        geometry, meshes = read_geometry(description, model, kind)
        geoms, items = np.array(list(geoms_of(theirs, kind)), dtype=int), geometry.geometryObjects
        labels, by_name = list(labels_of(theirs, geoms)), {item.name: item for item in items}
        assert sorted(by_name) == sorted(labels)
        places = [here.oMi[by_name[label].parentJoint] * by_name[label].placement for label in labels]
        require_places(places, [there.geom_xpos[geoms]], [there.geom_xmat[geoms]])
        for label, geom in zip(labels, geoms, strict=True):
            require_shape(meshes.get(label) or shape_of(by_name[label].geometry), theirs, geom)


def require_places(found: list[pin.SE3], positions: list[Floats], rotations: list[Floats]) -> None:
    expected = np.concatenate([*positions, np.zeros((0, 3))]), np.concatenate(rotations).reshape(-1, 3, 3)
    assert len(found) == len(expected[0])
    for place, position, rotation in zip(found, *expected, strict=True):
        np.testing.assert_allclose(place.translation, position, rtol=0, atol=1e-12)
        np.testing.assert_allclose(place.rotation, rotation, rtol=0, atol=1e-12)


def geoms_of(model: mujoco.MjModel, kind: str) -> Iterator[int]:
    for k in range(model.ngeom):
        collides = bool(model.geom_contype[k] or model.geom_conaffinity[k])
        if collides if kind == "collision" else not collides or model.geom_group[k] <= 2:
            yield k


def labels_of(model: mujoco.MjModel, geoms: Floats) -> Iterator[str]:
    seen: dict[str, int] = {}
    for k in geoms:
        link = _name(model.body(model.geom_bodyid[k]))
        yield f"{link}_{seen.setdefault(link, 0)}"
        seen[link] += 1


def require_shape(shape: Shape, model: mujoco.MjModel, geom: int) -> None:
    size = model.geom_size[geom]
    match shape:
        case Mesh():
            k = model.geom_dataid[geom]
            vertices = model.mesh_vert[model.mesh_vertadr[k] :]
            expected = vertices[model.mesh_face[model.mesh_faceadr[k] :][: model.mesh_facenum[k]]]
            # the order of a triangle's corners, and of triangles, is free in a mesh to look at
            corners = shape.vertices[shape.triangles].reshape(-1, 3)
            np.testing.assert_array_equal(np.unique(corners, axis=0), np.unique(expected.reshape(-1, 3), axis=0))
        case Box():
            np.testing.assert_array_equal(shape.size, 2 * size)
        case Sphere():
            assert shape.radius == size[0]
        case Capsule() | Cylinder():
            assert (shape.radius, shape.length) == (size[0], 2 * size[1])
    assert type(shape).__name__.lower() == mujoco.mjtGeom(model.geom_type[geom]).name.removeprefix("mjGEOM_").lower()


# robots


def test_bodies_joints_and_sites(tmp_path: Path) -> None:
    robot = Robot.load(arm(tmp_path))
    assert (robot.name, robot.joints, robot.tool) == ("small", ("j1", "j2"), "tip")
    assert robot.continuous.tolist() == [True, False]
    np.testing.assert_allclose([robot.lower, robot.upper], [[-np.pi, -2], [np.pi, 2]])
    assert {body.link: body.shape for body in robot.bodies} == {
        "base": Box((0.1, 0.08, 0.06)),
        "upper": Capsule(0.03, 0.3),
        "fore": Sphere(0.04),
    }
    q = np.array([[0.0, 0.0], [0.3, np.pi / 2]])
    expected = [[0, 0, 0.7], [0.2 * np.cos(0.3), 0.2 * np.sin(0.3), 0.5]]
    np.testing.assert_allclose(tool_positions(robot, q), expected, atol=1e-12)
    assert make_checker(robot, Scene("none")).first_contact(q) is None
    assert len(load_visuals(robot)) == 3
    assert "assumed: the URDF gives none" in MotionLimits.from_robot(robot).source["velocity"]


# couplings, notes and refusals


def test_a_coupled_joint_is_a_mimic_joint(tmp_path: Path) -> None:
    """MuJoCo measures how far a configuration is off an equality: by nothing where the joint follows."""
    rod = '<body name="rod"><joint name="k" axis="0 1 0" ref="-0.3"/><geom size="0.05"/></body>'
    equality = '<equality><joint joint1="k" joint2="j2" polycoef="0.1 -1.5 0 0 0"/></equality>'
    path = arm(tmp_path, rod, equality, replaced=('range="-2 2"', 'range="-2 2" ref="0.4"'))
    (mimic,) = urdf.read_description(Path(path)).mimics
    assert (mimic.joint, mimic.leader) == ("k", "j2")
    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    for value, off in ((0.7, 0.0), (-1.1, 0.0), (0.7, 0.2)):
        data.qpos[1:] = value, mimic.multiplier * value + mimic.offset + off
        mujoco.mj_forward(model, data)
        assert data.efc_pos[0] == pytest.approx(off, abs=1e-15)


SLIDE = '<body name="s"><joint name="s" type="slide"/><geom size=".1"/></body>'
REFUSED = {
    "an ellipsoid": ('<geom name="e" type="ellipsoid" size="0.1 0.2 0.3"/>', ""),
    "a ball joint": ('<body name="b"><joint name="b" type="ball"/><geom size="0.1"/></body>', ""),
    "a free joint": ("</body></body></body><body><freejoint/><geom size='1'/><body><body>", ""),
    "a missing mesh": ('<geom type="mesh" mesh="nothing"/>', ""),
    "a misspelt attribute": ('<geom size="0.1" poss="0 0 1"/>', ""),
    "a missing file": ('<include file="nowhere.xml"/>', ""),
    "a distant place": ('<body name="x" pos="0 0 1e9"><geom size="0.1"/></body>', ""),
    "a square": ("", '<equality><joint joint1="j1" joint2="j2" polycoef="0 1 0.5 0 0"/></equality>'),
    "a slide without limits": (SLIDE, ""),
}


@pytest.mark.parametrize(("extra", "after"), REFUSED.values(), ids=REFUSED)
def test_refusals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, extra: str, after: str) -> None:
    monkeypatch.chdir(tmp_path)
    assert refusal_of(lambda: Robot.load(arm(tmp_path, extra, after)))
    assert [path.name for path in tmp_path.iterdir()] == ["arm.xml"]  # MuJoCo writes no file of warnings
