"""Yoshikawa's measure against its closed form, its definition and its singular configurations."""

import numpy as np
import pytest

from planner.kinematics.forward import tool_pose
from planner.kinematics.manipulability import ROWS, jacobian, jacobians, manipulability, node_manipulability
from tests.worlds import ROBOTS, load, post_roadmap, random_q


def test_planar_2r_is_its_closed_form():
    robot = load("planar_2r")
    q = random_q(robot, 500)
    np.testing.assert_allclose(manipulability(robot, q), 0.5 * 0.4 * np.abs(np.sin(q[:, 1])), atol=1e-14)


@pytest.mark.parametrize("name", ROBOTS)
def test_jacobian_is_the_derivative_of_the_tool(name):
    robot, h = load(name), 1e-6
    for q in random_q(robot, 5, seed=1):
        columns = []
        for k in range(robot.dof):
            step = np.zeros(robot.dof)
            step[k] = h
            ahead, behind = tool_pose(robot, q + step), tool_pose(robot, q - step)
            turn = ahead.rotation @ behind.rotation.T
            angular = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
            columns.append(np.concatenate([ahead.translation - behind.translation, angular]) / (2 * h))
        np.testing.assert_allclose(jacobian(robot, q), np.array(columns).T[ROWS[robot.manipulability]], atol=1e-8)


@pytest.mark.parametrize("name", ROBOTS)
def test_square_is_the_determinant(name):
    robot = load(name)
    q = random_q(robot, 50)
    w = manipulability(robot, q)
    determinant = [np.linalg.det(j @ j.T) for j in jacobians(robot, q)]
    np.testing.assert_allclose(w**2, determinant, rtol=1e-6, atol=1e-14)
    assert (w >= 0).all()


def singular(name) -> np.ndarray:
    """Configurations whose Jacobian has lost a rank: stretched, or with a wrist whose axes line up."""
    robot, zero = load(name), np.zeros(load(name).dof)
    if name == "planar_2r":
        return np.array([[0.3, 0.0], [-2.0, 0.0]])
    if robot.dof == 7 and name != "xarm7":
        return np.array([zero, zero + np.eye(7)[0], zero + np.eye(7)[6]])
    wrist = {"ur5": 4, "ur10": 4}.get(name)
    if wrist is not None:
        q = random_q(robot, 20, seed=2)
        q[:, wrist] = 0.0
        return q
    return np.zeros((0, robot.dof))


@pytest.mark.parametrize("name", [name for name in ROBOTS if len(singular(name))])
def test_singular_configurations_are_zero_and_finite(name):
    w = manipulability(load(name), singular(name))
    assert np.isfinite(w).all()
    assert (w >= 0).all()
    assert (w < 1e-10).all()


@pytest.mark.parametrize("name", ROBOTS)
def test_turning_the_first_joint_changes_nothing(name):
    robot = load(name)
    q = random_q(robot, 10)
    turned = q.copy()
    turned[:, 0] = 0.1
    np.testing.assert_allclose(manipulability(robot, turned), manipulability(robot, q), rtol=1e-9, atol=1e-15)


def test_no_configurations():
    assert manipulability(load("iiwa14"), np.zeros((0, 7))).shape == (0,)


def test_the_papers_ends_are_near_singular(solved):
    # iiwa14.md: best 6-D Yoshikawa there 0.029 and 0.015, workspace mean 0.065
    w = solved.roadmap.manipulability
    assert w[solved.roadmap.starts[0]] == pytest.approx(0.029, abs=0.002)
    assert w[solved.roadmap.goals[0]] == pytest.approx(0.015, abs=0.002)
    assert manipulability(load("iiwa14"), random_q(load("iiwa14"), 1000)).mean() == pytest.approx(0.065, abs=0.01)


@pytest.mark.parametrize("name", ROBOTS)
def test_pinocchio_and_our_code_give_the_same_w(name):
    """Of nodes Pinocchio computes it, between them the compiled library; both are products of singular values."""
    robot = load(name)
    q = random_q(robot, 300, seed=4)
    ours, theirs = manipulability(robot, q), node_manipulability(robot, q)
    np.testing.assert_allclose(ours, theirs, rtol=1e-10, atol=1e-14)
    values = np.linalg.svd(jacobians(robot, q), compute_uv=False)
    np.testing.assert_allclose(theirs, values.prod(axis=1), rtol=1e-9, atol=1e-14)
    near = singular(name)
    if len(near):
        np.testing.assert_allclose(node_manipulability(robot, near), manipulability(robot, near), atol=1e-12)


def test_every_node_of_a_roadmap_has_pinocchios_w():
    roadmap = post_roadmap()
    np.testing.assert_array_equal(roadmap.manipulability, node_manipulability(load("planar_2r"), roadmap.nodes))
