"""The checker's own arithmetic, each part against another method."""

from typing import Any

import numpy as np
import pytest

from planner.certificate import verify_proof as checker
from planner.certificate.geometry import extract_geometry, split_shapes
from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements, tool_joint
from planner.robot.scene import Scene
from tests.worlds import load, random_q

ROBOTS = ("planar_2r", "panda", "ur5", "kinova")

NO_PAIRS: frozenset[frozenset[str]] = frozenset()


def world_of(robot: str) -> dict[str, Any]:
    data = extract_geometry(World.from_scene(load(robot), Scene.load("shelf"), NO_PAIRS))
    return data | {"shapes": split_shapes(data)}


def test_sine_and_cosine_are_within_what_is_said() -> None:
    """Against 64 bits of mantissa, the largest angles and those near multiples of a quarter turn too."""
    rng = np.random.default_rng(0)
    near = np.arange(-636, 637) * (np.pi / 2)
    q = np.concatenate(
        [rng.uniform(-1000, 1000, 20_000), near, near + rng.normal(size=len(near)) * 1e-8, [0.0, 1000.0]]
    )
    turned = checker.rotation(np.array([0.0, 0.0, 1.0]), q[:, None, None])
    exact = q.astype(np.longdouble)
    assert np.abs(turned[:, 1, 0] - np.sin(exact)).max() < 3e-12
    assert np.abs(turned[:, 0, 0] - np.cos(exact)).max() < 3e-12
    for angle in (1000.1, np.nan):
        with pytest.raises(checker.Refused, match="a joint turns too far"):
            checker.rotation(np.array([0.0, 0.0, 1.0]), angle)


@pytest.mark.parametrize("robot", ROBOTS)
def test_frames_are_those_of_the_robot(robot: str) -> None:
    q = random_q(load(robot), 50)
    turn, origin = checker.frames(world_of(robot), q)
    rotation, position = joint_placements(Chain.from_arm(load(robot)), q)
    np.testing.assert_allclose(turn, rotation, atol=1e-13)
    np.testing.assert_allclose(origin, position, atol=1e-13)


@pytest.mark.parametrize("robot", ROBOTS)
def test_no_point_moves_faster_than_is_said(robot: str) -> None:
    """Points of bodies and the tool, one joint at a time, at the configurations among many where it moves them most."""
    data, arm = world_of(robot), load(robot)
    carried, tool = tool_joint(arm)
    travel = np.maximum(np.abs(arm.lower), np.abs(arm.upper))
    reach, spare = checker.reaches(data, np.array([[travel]]))
    size = spare / checker.TURNED / (arm.dof + 1)  # and more where frames are not quite rotations
    q, step = random_q(arm, 300), 1e-6
    for joint in range(arm.dof):
        before, after = (checker.frames(data, q + by * np.eye(arm.dof)[joint]) for by in (-step, step))
        for item, (points, radius, _) in enumerate([*data["shapes"], (tool.translation[None], 0.0, False)]):
            carrier = int([*data["joint"], carried][item])
            if carrier < 1:
                assert not reach[item].any()
                continue
            there = [turn[carrier] @ points.T + origin[carrier][:, :, None] for turn, origin in (before, after)]
            speed = np.linalg.norm(there[1] - there[0], axis=1).max() / (2 * step)
            assert speed <= reach[item, joint] + 1e-8
            assert np.linalg.norm(there[0], axis=1).max() + radius <= size


@pytest.mark.parametrize("robot", ["panda", "iiwa14"])
def test_the_gap_is_that_of_supporting_planes(robot: str) -> None:
    """Of all points, and of rims sampled closely, none is beyond the planes, and some touch them."""
    data, rng = world_of(robot), np.random.default_rng(1)
    direction = rng.normal(size=(40, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    for shape in data["shapes"]:
        points, radius, cylinder = shape
        if cylinder:
            axis = points[1] - points[0]
            turned = rng.normal(size=(20_000, 3))
            turned -= np.outer(turned @ axis, axis) / (axis @ axis)
            rim = radius * turned / np.linalg.norm(turned, axis=1, keepdims=True)
            points, radius = np.concatenate([points[0] + rim, points[1] + rim]), 0.0
        far = (direction @ points.T).max(axis=1) + radius
        np.testing.assert_allclose(checker.farthest(shape, direction), far, atol=1e-5)
        assert (checker.farthest(shape, direction) >= far - 1e-12).all()
