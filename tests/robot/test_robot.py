"""Robots by name: facts about every robot, angles that wrap, and their identity."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.kinematics.forward import tool_pose
from planner.robot.poses import pose
from planner.robot.robot import Robot
from tests.random_shapes import QUICK
from tests.worlds import ROBOTS, load


@pytest.mark.parametrize("name", ROBOTS)
def test_every_robot(name):
    robot = load(name)
    assert robot.name == name
    assert robot.description
    assert robot.dof == len(robot.joints) == len(robot.lower) == len(robot.home) == robot.model.nq == robot.model.nv
    assert (robot.lower < robot.upper).all()
    assert np.isfinite([robot.lower, robot.upper]).all()
    assert ((robot.lower <= robot.home) & (robot.home <= robot.upper)).all()
    assert robot.bodies
    assert robot.model.frames[robot.tool_id].name == robot.tool
    assert robot.jacobian(robot.home).shape == (6, robot.dof)
    if robot.disabled_pairs is not None:
        links = {frame.name for frame in robot.model.frames}
        assert {len(pair) for pair in robot.disabled_pairs} <= {1, 2}
        assert any(set(pair) <= links for pair in robot.disabled_pairs)


# angles

ANGLES = st.lists(st.floats(-20, 20), min_size=6, max_size=6).map(np.array)


@QUICK
@given(ANGLES, ANGLES)
def test_difference_leads_from_a_to_b_the_shorter_way(a, b):
    robot = load("kinova")
    delta, wraps = robot.difference(a, b), robot.continuous
    np.testing.assert_array_equal(delta[~wraps], (b - a)[~wraps])
    assert (np.abs(delta[wraps]) <= np.pi + 1e-12).all()
    np.testing.assert_allclose(np.exp(1j * (a + delta))[wraps], np.exp(1j * b)[wraps], atol=1e-9)


@QUICK
@given(ANGLES)
def test_normalise_keeps_the_configuration(q):
    robot = load("kinova")
    plain, wraps = robot.normalise(q), robot.continuous
    assert ((plain[wraps] >= -np.pi) & (plain[wraps] <= np.pi)).all()
    np.testing.assert_array_equal(plain[~wraps], q[~wraps])
    np.testing.assert_allclose(tool_pose(robot, plain).homogeneous, tool_pose(robot, q).homogeneous, atol=1e-9)
    np.testing.assert_allclose(robot.normalise(plain), plain)


# set-up


def test_fixed_joints_move_the_links_on_them():
    narrow = Robot.load("panda", fixed_joints={"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0})
    assert narrow.identity != load("panda").identity
    shift = [
        np.linalg.norm(a.placement[:3, 3] - b.placement[:3, 3])
        for a, b in zip(narrow.bodies, load("panda").bodies, strict=True)
        if "finger" in a.link
    ]
    np.testing.assert_allclose(shift, 0.04, atol=1e-9)


# identity

VARIANTS = {
    "base": lambda: Robot.load("iiwa14", base=pose([0, 0, 0.1])),
    "tool": lambda: Robot.load("iiwa14", tool="iiwa14_link_7"),
    "limits": lambda: replace(load("iiwa14"), upper=load("iiwa14").upper * 0.9),
    "pairs": lambda: replace(load("iiwa14"), disabled_pairs=frozenset()),
    "no pairs": lambda: replace(load("iiwa14"), disabled_pairs=None),
    "jacobian_rows": lambda: replace(load("iiwa14"), jacobian_rows="translation"),
    "measure": lambda: replace(load("iiwa14"), measure="joint-limits"),
    "bodies": lambda: replace(load("iiwa14"), bodies=load("iiwa14").bodies[:-1]),
    "continuous": lambda: replace(load("iiwa14"), continuous=np.ones(7, dtype=bool)),
    "other robot": lambda: load("panda"),
}


@pytest.mark.parametrize("what", VARIANTS)
def test_identity_knows(what):
    assert VARIANTS[what]().identity != load("iiwa14").identity


# refusals


def test_only_motions_below_half_a_turn_are_given_by_their_ends():
    robot = load("kinova")
    turn = np.where(robot.continuous, np.pi, 4.0)
    assert robot.is_below_half_turn(np.array([0.9 * turn, turn, -turn])).tolist() == [True, False, False]
    assert load("iiwa14").is_below_half_turn(np.full((2, 7), 4.0)).all()
