"""A robot given as Pinocchio's models is the robot of the file that these were made of."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import planner
from planner.kinematics.forward import tool_pose
from planner.robot.files.meshes import split_into_components
from planner.robot.files.packages import example_robot_data
from planner.robot.robot import Robot, load_visuals
from planner.robot.shapes import Body, Mesh
from tests.worlds import joint_xml, link_xml, load

ROBOTS = ("iiwa14", "planar_2r", "ur5")
ARM = f"""<robot name="arm">{link_xml("base", '<box size="0.1 0.1 0.1"/>')}{link_xml("a", '<sphere radius="0.1"/>')}
{link_xml("b", '<cylinder radius="0.05" length="0.3"/>', '<origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/>')}{
    link_xml("tip")
}
{link_xml("l")}{link_xml("r", '<box size="0.1 0.02 0.1"/>')}
{joint_xml("j1", "base", "a", axis="0 0 -1", xyz="0 0 1", rpy="0.3 0 0", limit="-2 2")}
{joint_xml("j2", "a", "b", "continuous", axis="0 0.6 0.8", xyz="1 0 0")}{
    joint_xml("j3", "b", "tip", "fixed", xyz="0.5 0 0")
}
{joint_xml("f1", "tip", "l", "prismatic", axis="0 1 0", limit="0 0.04")}
{
    joint_xml("f2", "tip", "r", "prismatic", axis="0 1 0", limit="-0.02 0").replace(
        "<limit", '<mimic joint="f1" multiplier="-0.5" offset="0"/><limit'
    )
}</robot>"""


def models_of(robot: Robot) -> tuple[pin.Model, pin.GeometryModel, pin.GeometryModel]:
    """As Pinocchio reads the robot's URDF, with the collision pairs that the robot has."""
    folders = [example_robot_data().parent, *robot.source.path.resolve().parents]
    model, collision, visual = pin.buildModelsFromUrdf(str(robot.source.path), package_dirs=list(map(str, folders)))
    links = [model.frames[item.parentFrame].name for item in collision.geometryObjects]
    for i in range(collision.ngeoms if robot.disabled_pairs is not None else 0):
        for j in range(i):
            if frozenset((links[i], links[j])) not in (robot.disabled_pairs or ()) and links[i] != links[j]:
                collision.addCollisionPair(pin.CollisionPair(j, i))
    return model, collision, visual


def content(body: Body) -> list[Any]:
    """A body as plain data; Assimp, which Pinocchio reads meshes by, has their triangles in another order."""
    shape = body.shape
    rows = [shape.content()]
    if isinstance(shape, Mesh):
        corners = [sorted(map(tuple, triangle.tolist())) for triangle in shape.vertices[shape.triangles]]
        rows = [sorted(corners), len(shape.vertices), shape.radius]
    return [body.name, body.link, body.joint, body.placement.tolist(), body.color, *rows]


@pytest.mark.parametrize("name", ROBOTS)
def test_a_model_is_the_robot_of_its_file(name: str) -> None:
    read = load(name)
    made = Robot.from_pinocchio(*models_of(read), tool=read.tool, fixed_joints=read.fixed_joints)
    assert (made.joints, made.fixed_joints, made.name) == (read.joints, read.fixed_joints, read.name)
    for row in ("lower", "upper", "velocity", "continuous"):
        np.testing.assert_array_equal(getattr(made, row), getattr(read, row))
    for q in np.random.default_rng(3).uniform(read.lower, read.upper, (20, read.dof)):
        np.testing.assert_array_equal(tool_pose(made, q).homogeneous, tool_pose(read, q).homogeneous)
    bodies = [piece for body in read.bodies for piece in split_into_components(body)]
    assert list(map(content, made.bodies)) == list(map(content, bodies))
    assert len(load_visuals(made)) == len(load_visuals(read))
    for each in ("links", "bare", "continuous"):
        assert getattr(made.source, each) == getattr(read.source, each)
    assert dict(made.source.joints) == dict(read.source.joints)


def test_joints_that_mimic_and_turn_without_end() -> None:
    """Pinocchio keeps no limits of its own for a joint that mimics: it keeps those of its leader."""
    read = Robot.load(ARM, "tip")
    assert read.continuous.tolist() == [False, True]
    for mimic in (False, True):
        model = pin.buildModelFromXML(ARM, mimic)
        before = model.saveToString()
        geometry = pin.buildGeomFromUrdfString(model, ARM, pin.GeometryType.COLLISION)
        made = Robot.from_pinocchio(model, geometry, tool="tip")
        assert made.joints == read.joints
        for row in ("lower", "upper", "velocity", "continuous"):
            np.testing.assert_array_equal(getattr(made, row), getattr(read, row))
        q = np.array([0.3, 2.9])
        np.testing.assert_array_equal(tool_pose(made, q).homogeneous, tool_pose(read, q).homogeneous)
        assert list(map(content, made.bodies)) == list(map(content, read.bodies))
        moved = Robot.from_pinocchio(model, geometry, tool="r")
        assert moved.joints == (("j1", "j2", "f1") if mimic else ("j1", "j2", "f2"))
        assert [(item.joint, item.multiplier) for item in moved.followers] == ([("f2", -0.5)] if mimic else [])
        want = tool_pose(Robot.load(ARM, "r"), np.array([0.3, 2.9, 0.01])).homogeneous
        found = tool_pose(moved, np.array([0.3, 2.9, 0.01 if mimic else -0.005])).homogeneous
        np.testing.assert_allclose(found, want, atol=1e-15)
        assert model.saveToString() == before


def sample() -> tuple[pin.Model, pin.GeometryModel]:
    model = pin.buildSampleModelManipulator()
    return model, pin.buildSampleGeometryModelManipulator(model)


def test_a_model_made_by_hand() -> None:
    """Its joints hang on joints, not on links; it stands where Pinocchio puts it, and plans."""
    model, geometry = sample()
    robot = Robot.from_pinocchio(model, geometry, tool="effector_body", base=planner.pose([0, 0, 1]))
    data, frame = model.createData(), model.getFrameId("effector_body")
    for q in np.random.default_rng(0).uniform(robot.lower, robot.upper, (20, robot.dof)):
        pin.framesForwardKinematics(model, data, q)
        want = pin.SE3(np.eye(3), np.array([0.0, 0.0, 1.0])) * data.oMf[frame]
        np.testing.assert_allclose(tool_pose(robot, q).homogeneous, want.homogeneous, atol=1e-12)
    found = planner.plan(
        robot=robot, scene=None, start=np.zeros(6), goal=0.5 * np.ones(6), nodes=20, refinement_rounds=0
    )
    assert found.solved
    np.testing.assert_array_equal(found.scene.obstacles, ())
