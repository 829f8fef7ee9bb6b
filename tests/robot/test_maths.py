"""The public maths of a robot against Pinocchio, finite differences, NumPy and identities of the field."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from planner.cost.motion_cost import MotionCost
from planner.cost.scale import CostScale
from planner.kinematics.arm import frame_id
from planner.kinematics.manipulability import ROWS, manipulability_along, node_manipulability
from planner.problem.request import Objective as Cost
from tests.worlds import ROBOTS, load, random_q

STEP = 1e-6
MEASURES = ("inverse-condition", "min-singular-value", "joint-limits")
arms = pytest.mark.parametrize("name", ROBOTS)


@arms
def test_fk_is_pinocchios_for_every_frame(name: str) -> None:
    robot = load(name)
    q, data = random_q(robot, 3), robot.model.createData()
    for frame in {robot.tool, *(item.name for item in robot.model.frames)} - {"universe"}:
        poses = robot.fk(q.reshape(3, 1, -1), frame)
        assert poses.shape == (3, 1, 4, 4)
        for row, found in zip(q, poses[:, 0], strict=True):
            pin.framesForwardKinematics(robot.model, data, row)
            expected = data.oMf[frame_id(robot.model, frame)].homogeneous
            np.testing.assert_allclose(found, expected, atol=1e-12)
    np.testing.assert_array_equal(robot.fk(q[0]), robot.fk(q, robot.tool)[0])


@arms
def test_a_jacobian_is_the_slope_of_fk(name: str) -> None:
    robot = load(name)
    q = random_q(robot, 4, seed=1)
    for frame in (None, robot.model.frames[-1].name):
        found = robot.jacobian(q, frame)
        assert found.shape == (4, 6, robot.dof)
        for j in range(robot.dof):
            step = STEP * (np.arange(robot.dof) == j)
            after, before = robot.fk(q + step, frame), robot.fk(q - step, frame)
            np.testing.assert_allclose((after - before)[:, :3, 3] / (2 * STEP), found[:, :3, j], atol=1e-8)
            turn = after[:, :3, :3] @ before[:, :3, :3].swapaxes(1, 2)
            spin = np.array([pin.log3(each) for each in turn]) / (2 * STEP)
            np.testing.assert_allclose(spin, found[:, 3:, j], atol=1e-8)


@arms
def test_ik_undoes_fk(name: str) -> None:
    robot = load(name)
    q = random_q(robot, 1, seed=2)[0]
    found = robot.ik(robot.fk(q), near=q)
    np.testing.assert_allclose(robot.difference(found[0], q), 0.0, atol=1e-4)
    np.testing.assert_allclose(robot.fk(found), np.broadcast_to(robot.fk(q), (len(found), 4, 4)), atol=1e-4)
    by_position = robot.ik(robot.fk(q)[:3, 3])
    np.testing.assert_allclose(
        robot.fk(by_position)[:, :3, 3], np.tile(robot.fk(q)[:3, 3], (len(by_position), 1)), atol=2e-6
    )
    w = robot.manipulability(by_position)
    assert (np.diff(w) <= 1e-12).all()
    np.testing.assert_array_equal(robot.ik(pin.SE3(robot.fk(q)), near=q), found)
    assert robot.ik([50.0, 0.0, 0.0]).shape == (0, robot.dof)


@arms
@pytest.mark.parametrize("rows", ROWS)
def test_w_and_the_condition_number_are_those_of_the_rows(name: str, rows: str) -> None:
    robot = replace(load(name), jacobian_rows=rows)
    q = random_q(robot, 20)
    matrices = robot.jacobian(q)[:, slice(*ROWS[rows])]
    values = np.linalg.svd(matrices, compute_uv=False)
    np.testing.assert_allclose(robot.manipulability(q), values.prod(axis=1), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(node_manipulability(robot, q), values.prod(axis=1), rtol=1e-9, atol=1e-12)
    good = values[:, -1] > 1e-9
    np.testing.assert_allclose(robot.condition_number(q)[good], np.linalg.cond(matrices[good]), rtol=1e-9)
    if matrices.shape[1] <= robot.dof:  # Yoshikawa 1985
        square = np.linalg.det(matrices @ matrices.swapaxes(1, 2))
        np.testing.assert_allclose(robot.manipulability(q) ** 2, square, rtol=1e-6, atol=1e-9)


def test_other_measures_agree_with_numpy() -> None:
    robot = load("panda")
    q = random_q(robot, 30)
    by = {measure: replace(robot, measure=measure) for measure in MEASURES}
    values = np.linalg.svd(robot.jacobian(q), compute_uv=False)
    np.testing.assert_allclose(by["inverse-condition"].manipulability(q), 1 / robot.condition_number(q), rtol=1e-9)
    np.testing.assert_allclose(by["min-singular-value"].manipulability(q), values[:, -1], rtol=1e-9)

    def penalty(q: np.ndarray) -> np.ndarray:
        span = (robot.upper - robot.lower) ** 2
        return (span / (4 * (robot.upper - q) * (q - robot.lower))).sum(axis=1)

    scaled = robot.jacobian(q)
    for j in range(robot.dof):
        step = STEP * (np.arange(robot.dof) == j)
        slope = (penalty(q + step) - penalty(q - step)) / (2 * STEP)
        scaled[:, :, j] /= np.sqrt(1 + np.abs(slope))[:, None]
    expected = np.linalg.svd(scaled, compute_uv=False).prod(axis=1)
    np.testing.assert_allclose(by["joint-limits"].manipulability(q), expected, rtol=1e-5)
    at_limit = np.where(np.arange(robot.dof) == 3, robot.upper, q[0])
    assert by["joint-limits"].manipulability(at_limit) < 1e-3 * robot.manipulability(at_limit)


@pytest.mark.parametrize("measure", [*MEASURES, lambda q: 1.0 + np.sin(q).sum(axis=1) ** 2])
def test_edges_are_charged_for_the_integral_of_a_measure(measure: object) -> None:
    robot = replace(load("ur5"), measure=measure)
    scale = CostScale(w_low=0.05, w_high=1.0, joint_length=2.0, tool_length=1.0, zeta=0.01)
    cost = MotionCost(robot, scale, Cost(beta=0.3, manipulability_cost="linear"), longest=np.inf, states=801)
    a, b = random_q(robot, 6, seed=3), random_q(robot, 6, seed=4)
    length = np.linalg.norm(b - a, axis=1) / scale.joint_length
    w = manipulability_along(robot, a, b - a, np.linspace(0.0, 1.0, 801))
    omega = scale.zeta + (1 - scale.zeta) * np.clip((1.0 - np.clip(w, 0.05, 1.0)) / 0.95, 0.0, 1.0)
    mean = (omega[:, :-1] + omega[:, 1:]).mean(axis=1) / 2
    np.testing.assert_allclose(cost(a, b), 0.7 * mean * length + 0.3 * length, rtol=2e-3)
