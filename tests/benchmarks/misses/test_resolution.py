"""OMPL's rule for the resolution of an edge."""

from __future__ import annotations

import numpy as np
import pytest
from ompl import base as ob

from benchmarks.misses.resolution import states_by_ompls_rule
from benchmarks.misses.run import look_closely
from planner.collision import make_checker
from planner.models.poses import pose
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.models.shapes import Box, Obstacle
from tests.worlds import load, random_q


def _wall_between() -> tuple[Robot, Scene, np.ndarray, np.ndarray]:
    """A wall of 1 mm that planar_2r's stretched arm passes halfway between two states of OMPL's rule."""
    robot = load("planar_2r")
    start, delta = np.array([-0.08, 0.0]), np.array([0.16, 0.0])
    states = states_by_ompls_rule(robot, start, delta)
    assert len(states) == 3  # so 0 is looked at, and the wall stands beside it
    wall = Obstacle("wall", Box((0.02, 0.001, 0.5)), pose([0.895, 0.036, 0.0], rpy=[0, 0, 0.04]))
    return robot, Scene("wall", (wall,)), start, delta


def test_a_close_look_sees_what_ompls_rule_does_not() -> None:
    robot, scene, start, delta = _wall_between()
    checker = make_checker(robot, scene, "coal")
    assert checker.first_contact(states_by_ompls_rule(robot, start, delta)) is None
    touches, looks = look_closely(checker, start, delta)
    assert touches
    reach = float(checker.world.reach.motion(delta[None]).max())
    assert 0.3 * reach / 1e-4 < looks < reach / 1e-4  # up to the wall, halfway


@pytest.mark.parametrize("name", ["iiwa14", "panda", "planar_2r", "kinova"])
def test_the_rule_is_ompls(name: str) -> None:
    """OMPL's own count of segments, on a space made here as the planner makes it."""
    robot = load(name)
    space = _space(robot)
    info = ob.SpaceInformation(space)
    info.setStateValidityChecker(lambda state: True)
    info.setup()
    first, second = random_q(robot, 40, seed=1), random_q(robot, 40, seed=2)
    for a, b in zip(first, second, strict=True):
        parts = space.validSegmentCount(_state(info, robot, a), _state(info, robot, b))
        states = states_by_ompls_rule(robot, a, robot.difference(a, b))
        assert len(states) == parts + 1
        assert np.allclose(states[-1], a + robot.difference(a, b))
    assert len(states_by_ompls_rule(robot, first[0], np.zeros(robot.dof))) == 2


def _space(robot: Robot) -> ob.StateSpace:
    def real(lower: np.ndarray, upper: np.ndarray) -> ob.RealVectorStateSpace:
        part, bounds = ob.RealVectorStateSpace(len(lower)), ob.RealVectorBounds(len(lower))
        for k in range(len(lower)):
            bounds.setLow(k, float(lower[k]))
            bounds.setHigh(k, float(upper[k]))
        part.setBounds(bounds)
        return part

    if not robot.continuous.any():
        return real(robot.lower, robot.upper)
    space = ob.CompoundStateSpace()
    for k, wraps in enumerate(robot.continuous):
        part = ob.SO2StateSpace() if wraps else real(robot.lower[k : k + 1], robot.upper[k : k + 1])
        space.addSubspace(part, 1.0)
    return space


def _state(info: ob.SpaceInformation, robot: Robot, q: np.ndarray) -> ob.State:
    state = info.allocState()
    for k, value in enumerate(robot.normalise(q)):
        if not robot.continuous.any():
            state[k] = float(value)
        elif robot.continuous[k]:
            state[k].value = float(value)
        else:
            state[k][0] = float(value)
    return state
