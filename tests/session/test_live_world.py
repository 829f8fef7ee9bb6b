"""Changes of a world: each gives a new whole and leaves the old one, or an error and nothing."""

from __future__ import annotations

import numpy as np
import pytest

from planner.base.errors import SceneError
from planner.problem.request import WorldRequest
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Carried, Obstacle, Sphere
from planner.session.live_world import LiveWorld
from tests.worlds import load, make_post

FAR = Obstacle("far", Sphere(0.1), pose([0.0, 0.0, 3.0]))
Q = np.array([0.5, 1.0])


def bare() -> LiveWorld:
    return LiveWorld.of(WorldRequest(load("planar_2r"), make_post().world.scene))


def names(world: LiveWorld) -> list[str]:
    return [obstacle.name for obstacle in world.scene.obstacles]


def test_what_is_attached_moves_with_the_arm_and_is_put_down_where_it_is_held() -> None:
    world = bare().add(FAR)
    held = world.attach("far", "link_2", (), Q)
    assert names(held) == ["thing0"]
    assert [item.name for item in held.scene.carried] == ["far"]
    np.testing.assert_allclose(held.detach("far", Q).scene.obstacles[-1].placement, FAR.placement, atol=1e-12)
    turned = held.detach("far", Q + np.array([0.7, 0.0])).scene.obstacles[-1].placement
    turn = pose(rpy=[0.0, 0.0, 0.7])
    np.testing.assert_allclose(turned, turn @ FAR.placement, atol=1e-12)


def test_what_the_scene_says_is_carried_is() -> None:
    ball = Carried("link_2", "ball", Sphere(0.05), pose([0.45, 0, 0]), ("link_2",))
    world = LiveWorld.of(WorldRequest(load("planar_2r"), Scene("made", (), carried=(ball,))))
    assert [body.name for body in world.checker.robot.carried] == ["ball"]
    assert not world.bare.carried
    with pytest.raises(SceneError, match="it is carried: detach it first"):
        world.remove("ball")
