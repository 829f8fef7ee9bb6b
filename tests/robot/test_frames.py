"""Obstacles given in frames other than the scene's own stand where those frames are."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from planner.collision import make_checker
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.robot_in_scene import resolve_frames
from planner.robot.scene import Scene
from tests.refusals import refusal_of
from tests.robot.files.moveit.samples import SCENE, changed

BASE = pose((0.1, 0.2, 0.9), rpy=(0.0, 0.0, 1.57))
FRAMES = [
    {"child_frame_id": "world", "transform": {}},
    {"child_frame_id": "/cell", "transform": {"translation": {"x": 1, "y": 0, "z": 0}, "rotation": [0, 0, 1, 0]}},
    {"child_frame_id": "on_base", "header": {"frame_id": "panda_link0"}, "transform": {"translation": [0, 0, 1]}},
    {"child_frame_id": "on_floor", "header": {"frame_id": "floor"}, "transform": {"translation": [0, 0, 2]}},
]


def scene_in(frame: str, folder: Path) -> Scene:
    message = changed(SCENE, "fixed_frame_transforms", FRAMES)
    (folder / "s.yaml").write_text(yaml.safe_dump(changed(message, "world.collision_objects.0.header.frame_id", frame)))
    return Scene.load(str(folder / "s.yaml"))


@pytest.mark.parametrize(
    ("frame", "at"),
    [
        ("", np.eye(4)),
        ("world", np.eye(4)),
        ("panda_link0", BASE),
        ("cell", pose((1, 0, 0), quaternion=(0, 0, 1, 0))),
        ("on_base", BASE @ pose((0, 0, 1))),
        ("on_floor", pose((0, 0, 2))),
        ("floor", np.eye(4)),
    ],
)
def test_an_object_stands_in_its_frame(frame: str, at: np.ndarray, tmp_path: Path) -> None:
    robot = Robot.load("panda", base=BASE)
    (table, post) = make_checker(robot, scene_in(frame, tmp_path), "coal").world.obstacles
    np.testing.assert_allclose(table.placement, at @ pose((0.55, 0, 0.1)), atol=1e-12)
    np.testing.assert_allclose(post.placement, BASE @ pose((0.5, 0, 0.37)), atol=1e-12)  # as panda_link0 says
    assert table.frame == post.frame == ""


@pytest.mark.parametrize(
    ("frame", "part"),
    [
        ("panda_link4", "object 'table' of scene 'example' is given in frame 'panda_link4', which moves with the arm"),
        ("cel", "is given in frame 'cel' (did you mean 'cell'?), which neither"),
        ("post/top", "is given in frame 'post/top', which neither"),
    ],
)
def test_a_frame_without_a_place_is_refused(frame: str, part: str, tmp_path: Path) -> None:
    scene = scene_in(frame, tmp_path)
    assert part in refusal_of(lambda: make_checker(Robot.load("panda"), scene, "coal"))


@pytest.mark.parametrize("link", ["panda_link0", "panda_link4"])
def test_a_fixed_frame_that_is_a_link_stands_where_the_link_does(link: str, tmp_path: Path) -> None:
    """Whether an object refers to it or not: else the base would stand elsewhere than the message says."""
    placed = {"child_frame_id": link, "transform": {"translation": [0.0, 0.0, 0.9]}}
    (tmp_path / "s.yaml").write_text(yaml.safe_dump(changed(SCENE, "fixed_frame_transforms", [placed])))
    scene = Scene.load(str(tmp_path / "s.yaml"))
    text = refusal_of(lambda: make_checker(Robot.load("panda"), scene, "coal"))
    assert f"of scene 'example' place '{link}', which is a link of the robot and not there" in text
    if link == "panda_link0":
        table = resolve_frames(scene, Robot.load("panda", base=pose((0, 0, 0.9)))).obstacles[0]
        np.testing.assert_allclose(table.placement, pose((0.55, 0, 1.0)), atol=1e-12)
