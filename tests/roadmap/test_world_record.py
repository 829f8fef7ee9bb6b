"""What has changed between the world that a roadmap remembers and this one."""

from __future__ import annotations

from dataclasses import replace

from planner.collision import make_checker
from planner.models.poses import pose
from planner.roadmap.storage import same_world
from planner.roadmap.world_record import changes, record_of, unproven_pairs
from tests.construction.test_repair import AT, OLD, POST, WORLDS, made
from tests.worlds import load, make_post, scene_of


def test_differences_by_name():
    record = record_of(make_post().world)
    told = {name: changes(record, make().world) for name, make in WORLDS.items()}
    assert told["as it was"] == []
    assert told["moved"] == ["obstacle 'thing0' moved"]
    assert told["added"] == ["obstacle 'ball' added"]
    assert told["removed"] == ["obstacle 'thing0' removed"]
    assert told["renamed"] == ["obstacle 'thing0' removed", "obstacle 'pillar' added"]
    assert told["of another shape"] == ["obstacle 'thing0' of another shape"]
    assert told["something carried"] == ["body 'finger' added"]
    assert told["another place"] == ["the robot's base or joints placed elsewhere", "body 'link_0_0' changed"]
    assert told["a larger margin"] == []


def test_the_same_shape_twice_is_known_by_either():
    """Two equal obstacles change places: nothing has to be looked at."""
    a, b = pose([0.7, 0.2, 0]), pose([-0.7, 0.2, 0])
    one, other = made(x=(POST, a), y=(POST, b)), made(x=(POST, b), y=(POST, a))
    assert changes(record_of(one.world), other.world) == ["obstacle 'x' moved", "obstacle 'y' moved"]
    assert not any(mask.any() for mask in unproven_pairs(record_of(one.world), other.world))


def test_a_scene_made_otherwise_is_the_same_if_its_things_are():
    assert same_world(OLD, make_checker(load("planar_2r"), scene_of((POST, AT))))
    assert same_world(OLD, made(thing0=(POST, AT)))


def test_joints_held_elsewhere_are_told_first():
    record = replace(OLD.origin.world, held={"finger": 0.02})
    assert changes(record, make_post().world) == [
        "joints that are not planned held elsewhere, see --joints and --request"
    ]
