"""Robots with several tools: inverse kinematics of all at once, and the least manipulability of any."""

import numpy as np
import pinocchio as pin
import pytest

from planner.base.errors import OptionError, RobotError
from planner.constraints.floor import prove_floor
from planner.cost.motion_cost import MotionCost
from planner.cost.scale import CostScale, manipulability_cost
from planner.kinematics.forward import tool_path_lengths, tool_positions
from planner.kinematics.manipulability import manipulability, manipulability_along, node_manipulability
from planner.problem.request import Objective
from planner.robot.robot import with_tool
from tests.two_arms import BOTH, load_two_arms
from tests.worlds import load, random_q

TOOLS = BOTH.split(",")


def pose_of(robot, q, frame):
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    return data.oMf[robot.model.getFrameId(frame, pin.FrameType.BODY)].copy()


def volumes(robot, q):
    """The product of singular values of each tool's Jacobian by Pinocchio (n, tools)."""
    data, aligned = robot.model.createData(), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    frames = [robot.model.getFrameId(name, pin.FrameType.BODY) for name in robot.tools]
    rows = [[pin.computeFrameJacobian(robot.model, data, row, frame, aligned) for frame in frames] for row in q]
    return np.linalg.svd(np.array(rows), compute_uv=False).prod(axis=2)


def test_inverse_kinematics_brings_all_tools_to_their_targets():
    robot, solved = load_two_arms(), 0
    for q in random_q(robot, 3, seed=1):
        left, right = (pose_of(robot, q, name) for name in TOOLS)
        for found in robot.ik({"left_tool": left, "right_tool": right.translation}, starts=60):
            assert np.abs(pose_of(robot, found, "left_tool").homogeneous - left.homogeneous).max() < 5e-6
            assert np.abs(pose_of(robot, found, "right_tool").translation - right.translation).max() < 5e-6
            solved += 1
    assert solved >= 10


def test_w_is_the_least_of_any_tool():
    robot, q = load_two_arms(), random_q(load_two_arms(), 9, seed=2)
    each = volumes(robot, q)
    assert {*each.argmin(axis=1).tolist()} == {0, 1}
    for w in (manipulability(robot, q), node_manipulability(robot, q), robot.manipulability(q)):
        np.testing.assert_allclose(w, each.min(axis=1), rtol=1e-9)
    shares, delta = np.array([0.0, 0.5, 1.0]), 0.3 * random_q(robot, 9, seed=3)
    along = volumes(robot, (q[:, None] + shares[:, None] * delta[:, None]).reshape(-1, robot.dof)).min(axis=1)
    np.testing.assert_allclose(manipulability_along(robot, q, delta, shares).ravel(), along, rtol=1e-9)
    largest = np.max([with_tool(robot, name).condition_number(q) for name in TOOLS], axis=0)
    np.testing.assert_array_equal(robot.condition_number(q), largest)


def test_motions_cost_the_integral_of_the_least_w():
    robot, scale = load_two_arms(), CostScale(w_low=1e-3, w_high=0.03, joint_length=2.0, tool_length=1.5, zeta=0.01)
    a, delta, s = random_q(robot, 12, seed=4), 0.05 * random_q(robot, 12, seed=5), np.linspace(0, 1, 501)
    w = np.array([volumes(robot, q + s[:, None] * by).min(axis=1) for q, by in zip(a, delta, strict=True)])
    omega = np.trapezoid(manipulability_cost(w, scale, "log"), s, axis=1)
    for metric, unit in (("joint", 2.0), ("workspace", 1.5)):
        path = np.array([[with_tool(robot, name).fk(q + s[:, None] * by)[:, :3, 3] for name in TOOLS]
                         for q, by in zip(a, delta, strict=True)])  # fmt: skip
        lengths = np.linalg.norm(np.diff(path, axis=2), axis=3).sum(axis=(1, 2))
        distance = (np.linalg.norm(delta, axis=1) if metric == "joint" else lengths) / unit
        cost = MotionCost(robot, scale, Objective(0.3, metric=metric), longest=np.inf)
        np.testing.assert_allclose(cost(a, a + delta), 0.7 * omega * distance + 0.3 * distance, rtol=0.01)
    np.testing.assert_allclose(tool_path_lengths(robot, a, delta), lengths, rtol=1e-3)


def test_a_floor_is_proven_for_every_tool():
    robot = load_two_arms()
    a, delta, s = random_q(robot, 30, seed=6), 0.03 * random_q(robot, 30, seed=7), np.linspace(0, 1, 60)
    w = np.array([volumes(robot, q + s[:, None] * by) for q, by in zip(a, delta, strict=True)])
    low, floor = w.min(axis=1), 0.004
    proofs = prove_floor(robot, np.stack([a, delta], axis=1), floor)
    assert not (proofs.holds & (low.min(axis=1) < floor)).any()
    assert not (proofs.broken & (low.min(axis=1) > floor)).any()
    for tool in (0, 1):  # some fail by this tool alone, and some hold
        assert (proofs.broken & (low[:, tool] < floor) & (low[:, 1 - tool] > 2 * floor)).any()
    assert proofs.holds.sum() >= 5
    assert (proofs.lowest[proofs.holds] <= low.min(axis=1)[proofs.holds]).all()


def test_one_tool_is_the_robot_as_it_was():
    robot = load("panda")
    assert robot.with_each_tool == (robot,)
    assert with_tool(robot, robot.tool) is robot
    two = with_tool(robot, f"{robot.tool},panda_link4")
    assert two.identity != robot.identity == with_tool(two, robot.tool).identity
    assert np.array_equal(tool_positions(two, robot.home), tool_positions(robot, robot.home))


@pytest.mark.parametrize("tool", ["left_tool,", "left_tool,left_tool"])
def test_tools_must_differ(tool):
    with pytest.raises(OptionError, match="tool must be a frame, or different frames"):
        load_two_arms(tool)


def test_a_tool_that_is_no_frame():
    with pytest.raises(RobotError, match="'third_tool' not found"):
        load_two_arms("left_tool,third_tool")
