"""Obstacles that move: where they are at a time, how quick any point of them is, and how scene files say so."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from planner.base.errors import SceneError
from planner.problem.request import RoadmapRequest
from planner.query.query import make_query
from planner.robot.moving import KnownMotion
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, corners
from tests.random_shapes import random_shape

TIMES = [0.0, 0.7, 2.0, 2.5]


def drawn(seed: int) -> KnownMotion:
    rng = np.random.default_rng(seed)
    return KnownMotion(TIMES, [pose(rng.uniform(-1, 1, 3).tolist(), rng.uniform(-3, 3, 3).tolist()) for _ in TIMES])


@pytest.mark.parametrize("seed", range(4))
def test_a_motion_is_linear_in_place_and_turns_the_shorter_way_as_scipy_has_it(seed: int) -> None:
    motion, t = drawn(seed), np.linspace(-0.5, 3.0, 50)
    found = motion.at(t)
    inside = np.clip(t, 0.0, 2.5)
    for k in range(3):
        np.testing.assert_allclose(found[:, k, 3], np.interp(t, TIMES, motion.poses[:, k, 3]), atol=1e-12)
    turns = Slerp(TIMES, Rotation.from_matrix(motion.poses[:, :3, :3]))(inside).as_matrix()
    np.testing.assert_allclose(found[:, :3, :3], turns, atol=1e-9)


@pytest.mark.parametrize("kind", ["box", "sphere", "capsule", "mesh"])  # of a cylinder corners() says too much
def test_no_point_is_quicker_than_the_speed_says(kind: str) -> None:
    motion, shape = drawn(9), random_shape(np.random.default_rng(3), kind)
    points, radius = corners(shape)
    directions = np.vstack([np.eye(3), -np.eye(3)]) if radius else np.zeros((1, 3))
    points = (points[:, None] + radius * directions).reshape(-1, 3)
    for k, speed in enumerate(motion.speeds(shape)):
        poses = motion.at(np.linspace(TIMES[k], TIMES[k + 1], 201)[:-1])
        places = points @ poses[:, :3, :3].transpose(0, 2, 1) + poses[:, None, :3, 3]
        fastest_phases = np.linalg.norm(np.diff(places, axis=0), axis=2).max() / ((TIMES[k + 1] - TIMES[k]) / 200)
        assert 0.3 * speed < fastest_phases <= speed * (1 + 1e-9)


def test_a_jump_within_a_microsecond_is_a_motion() -> None:
    motion = KnownMotion([0.0, 5.0, 5.0 + 2e-6], [pose(), pose(), pose([0, 0, 9])])
    np.testing.assert_allclose(motion.at(np.array([5.0, 6.0]))[:, 2, 3], [0, 9])
    speeds = motion.speeds_at(np.array([1.0, 5.0 + 1e-6, 7.0]), Box((0.1, 0.1, 0.1)))
    np.testing.assert_allclose(speeds, [0, 9 / 2e-6, 0], rtol=1e-6)


FILE = """
obstacles:
  - {name: shelf, type: box, size: [0.1, 0.1, 0.1], position: [1, 1, 1]}
  - {name: visitor, type: sphere, radius: 0.2, position: [2, 0, 0.5], speed_limit: 0.25}
  - name: cart
    type: box
    size: [0.2, 0.3, 0.4]
    motion: [{t: 0, position: [1, -1, 0]}, {t: 4, position: [1, 1, 0], rpy: [0, 0, 1.5]}]
"""


def test_a_scene_file_describes_moving_obstacles(tmp_path: Path) -> None:
    path = tmp_path / "moving.yaml"
    path.write_text(FILE)
    scene = Scene.load(str(path))
    assert [item.name for item in scene.obstacles] == ["shelf", "visitor"]
    assert [item.name for item in scene.limited] == ["visitor"]
    (cart,) = scene.moving
    assert cart.shape == Box((0.2, 0.3, 0.4))
    np.testing.assert_allclose(cart.standing(2.0).placement, pose([1, 0, 0], [0, 0, 0.75]), atol=1e-12)
    still = Scene("same", scene.obstacles)
    assert still.identity == scene.identity  # roadmaps are of the world that stands still
    with pytest.raises(SceneError, match="timing=None"):
        make_query(RoadmapRequest.from_options(robot="planar_2r", scene=str(path), start="q:0,0", goal="q:1,0").what)
