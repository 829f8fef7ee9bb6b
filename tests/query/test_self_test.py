"""A robot tried before a user does: pairs of links that stand in the way are named."""

from __future__ import annotations

import re

import pytest

from planner.collision.coal import CoalChecker
from planner.collision.world import World
from planner.query.self_test import try_robot
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from tests.worlds import joint_xml, link_xml, load


def test_a_built_in_robot_is_free_at_home_and_reaches_targets() -> None:
    robot = load("panda")
    (sentence,) = try_robot(CoalChecker(World.of(robot, Scene("none"), robot.disabled_pairs or frozenset())))
    assert re.search(r"home is free, [78] of 8 tool positions are reached, [6-9]\d % of", sentence)


@pytest.mark.parametrize("touches", [True, False])
def test_pairs_in_the_way_are_named(urdf_file, touches: bool) -> None:
    """A bar turns about z, over a disc that is wide enough or not."""
    links = link_xml("a") + link_xml("b", '<box size="0.02 0.02 0.02"/>', origin='<origin xyz="0.5 0 0"/>')
    links += link_xml("disc", f'<cylinder radius="{0.55 if touches else 0.4}" length="0.01"/>') + link_xml("m")
    joints = joint_xml("j", "a", "b", limit="-3 3") + joint_xml("weld", "a", "m", "fixed")
    robot = Robot.load(urdf_file(links + joints + joint_xml("k", "m", "disc")), tool="b")
    summary, *pairs = try_robot(CoalChecker(World.of(robot, Scene("none"), frozenset())))
    home, reached, free = ("in collision", 0, 0) if touches else ("free", 8, 100)
    assert f"home is {home}, {reached} of 8 tool positions are reached, {free} % of" in summary
    assert len(pairs) == touches
    assert all("'b' and 'disc' touch at home and in 100 % of random configurations:" in pair for pair in pairs)
