"""PlanningScene messages: what may touch, what is carried."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from planner.collision import make_checker
from planner.collision.checker import contact_of
from planner.models.robot import Robot, with_carried
from planner.models.scene import Scene
from planner.models.shapes import Box, Carried
from tests.models.files.moveit.samples import BOX, scene


def test_the_matrix_allows_robot_against_object_only(tmp_path: Path) -> None:
    lump = {
        "id": "lump",
        "primitives": [{"type": "sphere", "dimensions": [0.2]}],
        "primitive_poses": [{"position": [0, 0, 1.3]}],
    }
    names = [f"iiwa14_link_{k}" for k in range(8)]
    everything = [[True] * 9 for _ in range(9)]
    allowing = scene(lump, allowed_collision_matrix={"entry_names": [*names, "lump"], "entry_values": everything})
    for message, touches in ((scene(lump), True), (allowing, False)):
        (tmp_path / "s.yaml").write_text(yaml.safe_dump(message))
        robot, world = Robot.load("iiwa14"), Scene.load(str(tmp_path / "s.yaml"))
        checker = make_checker(robot, world)
        assert (contact_of(checker, np.zeros(7)) is not None) == touches
        # what a matrix says of two robot links changes nothing
        assert len(checker.world.self_pairs) == len(make_checker(robot, Scene("none")).world.self_pairs)
    assert Scene.load(str(tmp_path / "s.yaml")).identity != Scene("x", world.obstacles).identity


def test_a_carried_box_collides_in_the_arms_stead(tmp_path: Path) -> None:
    robot = Robot.load("iiwa14")
    held = with_carried(robot, [Carried("flange", "parcel", Box((0.1, 0.1, 0.1)), np.eye(4), ("iiwa14_link_6",))])
    wall = scene({**BOX, "id": "wall", "primitive_poses": [{"position": [0, 0, 1.5]}]})
    (tmp_path / "s.yaml").write_text(yaml.safe_dump(wall))
    world = Scene.load(str(tmp_path / "s.yaml"))
    assert contact_of(make_checker(robot, world), np.zeros(7)) is None
    contact = contact_of(make_checker(held, world), np.zeros(7))
    assert contact is not None
    assert (contact.first, contact.second) == ("parcel", "wall")
    assert held.identity != robot.identity
