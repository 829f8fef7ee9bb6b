"""Inverse kinematics, judged by Pinocchio's forward kinematics."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import least_squares

from planner.kinematics import inverse
from planner.query.inverse_targets import IK_STARTS
from planner.robot.poses import pose
from planner.robot.robot import Robot
from tests.worlds import FEW_AXES, ROBOTS, arm_of_few_axes, joint_xml, link_xml, load, random_q

STARTS = 25


def tool(robot: Robot, q: np.ndarray) -> pin.SE3:
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    return data.oMf[robot.model.getFrameId(robot.tool, pin.FrameType.BODY)].copy()


def assert_solved(robot, found, target, oriented):
    assert len(found.configurations)
    for q in found.configurations:
        miss = target.actInv(tool(robot, q))
        assert np.linalg.norm(miss.translation) <= 2e-6
        assert not oriented or np.linalg.norm(pin.log3(miss.rotation)) <= 2e-6
        inside = (robot.lower - 1e-12 <= q) & (q <= robot.upper + 1e-12)
        assert inside.all()
    assert found.distance <= inverse.POSITION_TOLERANCE


@pytest.mark.parametrize("name", ROBOTS)
def test_positions(name):
    robot, rng = load(name), np.random.default_rng(0)
    for q in random_q(robot, 2, seed=5):
        target = tool(robot, q)
        found = inverse.solve(robot, target.translation, rng, STARTS)
        assert_solved(robot, found, pin.SE3(np.eye(3), target.translation), False)
        assert found.angle == 0.0


@pytest.mark.parametrize("name", [name for name in ROBOTS if load(name).dof >= 6])
def test_poses(name):
    robot, rng = load(name), np.random.default_rng(0)
    for q in random_q(robot, 2, seed=6):
        assert_solved(robot, inverse.solve(robot, tool(robot, q), rng, 60), tool(robot, q), True)


@pytest.mark.parametrize(
    "direction",
    [
        (1, 0, 0),
        (0, -1, 0),
        (0.6, 0, 0.8),
        (-0.36, 0.48, 0.8),
    ],
)
def test_the_residual_of_an_unreachable_target(direction):
    """iiwa14's flange leaves the sphere of 0.946 m about the shoulder nowhere."""
    robot, shoulder = load("iiwa14"), np.array([0, 0, 0.36])
    target = shoulder + 1.2 * np.array(direction)
    found = inverse.solve(robot, target, np.random.default_rng(0), IK_STARTS)
    assert len(found.configurations) == 0
    assert found.distance == pytest.approx(1.2 - 0.946, abs=2e-3)
    assert np.linalg.norm(tool(robot, found.nearest).translation - target) == pytest.approx(found.distance)
    assert inverse.beyond_reach(robot, target) == pytest.approx(1.2 - 0.946, abs=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_reached_point_is_not_beyond_reach(name):
    robot = load(name)
    turned = Robot.load(name, base=pose([0.4, -0.3, 0.2], rpy=[0.2, -0.4, 1.0]))
    for some in (robot, turned):
        for q in random_q(some, 100, seed=9):
            assert inverse.beyond_reach(some, tool(some, q).translation) <= 1e-9


@pytest.mark.parametrize("first", ["prismatic", "revolute"])
def test_sliding_joints_reach_further(urdf_file, first):
    links = "".join(link_xml(name) for name in "abcd")
    joints = (
        joint_xml("j1", "a", "b", first, "1 0 0", xyz="0 0 0.1", limit="-1 1")
        + joint_xml("j2", "b", "c", axis="0 0 1", xyz="0 0.3 0")
        + joint_xml("j3", "c", "d", "prismatic", "0 1 0", xyz="0.2 0 0", limit="-0.5 0.5")
    )
    robot = Robot.load(urdf_file(links + joints))
    for q in random_q(robot, 200):
        assert inverse.beyond_reach(robot, tool(robot, q).translation) <= 1e-9


@pytest.mark.parametrize("name", ["panda", "ur5", "iiwa14"])
@pytest.mark.parametrize("free", [False, True])
def test_each_seed_has_its_own_target(name: str, free: bool) -> None:
    """Near its own solution every descent finds its own target; with a free turn it need not keep to that."""
    robot, rng = load(name), np.random.default_rng(1)
    q = 0.8 * random_q(robot, 12, seed=3)
    targets = [tool(robot, row) for row in q]
    turned = [target * pin.SE3(pin.exp3(np.array([0, 0, 0.4])), np.zeros(3)) if free else target for target in targets]
    seeds = q + rng.normal(scale=0.02, size=q.shape)
    found, distance, angle = inverse.solve_each(robot, np.array([t.homogeneous for t in turned]), seeds, free)
    solved = (distance <= inverse.POSITION_TOLERANCE) & (angle <= inverse.ANGLE_TOLERANCE)
    assert solved.sum() >= 10
    for row, target in zip(found[solved], [t for t, ok in zip(turned, solved, strict=True) if ok], strict=True):
        miss = target.actInv(tool(robot, row))
        assert np.linalg.norm(miss.translation) <= 1e-6 + 1e-9
        lean = np.arccos(np.clip(miss.rotation[2, 2], -1, 1)) if free else np.linalg.norm(pin.log3(miss.rotation))
        assert lean <= 2e-6
    if free:  # not all the way to the other turn: the least motion
        turns = [
            np.linalg.norm(pin.log3(t.actInv(tool(robot, row)).rotation)) for t, row in zip(turned, found, strict=True)
        ]
        assert max(turns) > 0.1


def miss_of(robot: Robot, q: np.ndarray, target: pin.SE3) -> np.ndarray:
    """(6,) how far the tool is off, in tolerances: metres by 1e-6, radians by 1e-4."""
    off = target.actInv(tool(robot, q))
    return np.concatenate([off.translation / 1e-6, pin.log3(off.rotation) / 1e-4])


@pytest.mark.parametrize("name", FEW_AXES)
def test_poses_of_arms_of_few_axes_are_reached_as_nearly_as_they_can_be(name: str, urdf_file) -> None:
    """By SciPy's least squares over Pinocchio, from where the arm without rounding reaches them."""
    exact, robot = (arm_of_few_axes(name, urdf_file, sharp) for sharp in (True, False))
    missed = []
    for q in 0.9 * random_q(exact, 12, seed=8):
        target = tool(exact, q)
        found = inverse.solve(robot, target, np.random.default_rng(0), IK_STARTS)
        bounds = robot.lower - 1e-9, robot.upper + 1e-9
        want = least_squares(lambda x, to=target: miss_of(robot, x, to), q, bounds=bounds, xtol=1e-15, ftol=1e-15)
        assert len(found.configurations)
        misses = [miss_of(robot, one, target) for one in found.configurations]
        assert all(np.linalg.norm(part) <= 1.0 + 1e-9 for miss in misses for part in (miss[:3], miss[3:]))
        if max(found.distance, found.angle) > inverse.ANGLE_TOLERANCE:
            missed.append(min(map(np.linalg.norm, misses)) / np.sqrt(2 * want.cost))
    assert missed, "all are reached exactly"
    assert max(missed) <= 1.01
    turned = tool(exact, 0.9 * random_q(exact, 1, seed=8)[0]) * pin.SE3(
        pin.exp3(np.array([0.0, 2e-2, 0.0])), np.zeros(3)
    )
    far = inverse.solve(robot, turned, np.random.default_rng(0), IK_STARTS)
    allowed = 1.1 * far.distance + 1e-6, 1.1 * far.angle
    near = inverse.solve(robot, turned, np.random.default_rng(0), IK_STARTS, tolerance=allowed)
    assert (len(far.configurations), len(near.configurations) > 0) == (0, True)
