"""The text of a robot file loads as the same robot, with reasons for its pairs; a self-test names links that touch."""

from pathlib import Path

import pytest

from planner.base.resources import robots_folder
from planner.collision.coal import CoalChecker
from planner.collision.self_pairs import generate_disabled_pairs
from planner.collision.world import World
from planner.query.robot_yaml import robot_yaml, self_test
from planner.robot.files.robot_files import read_robot
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from tests.worlds import joint_xml, link_xml

ARM = str(robots_folder() / "examples" / "arm.urdf")


def test_it_loads_as_the_same_robot_with_its_pairs(tmp_path: Path) -> None:
    files, robot = read_robot(ARM, None), Robot.load(ARM, tool="tip")
    pairs = generate_disabled_pairs(robot, CoalChecker)
    text = robot_yaml(files, robot, pairs, tmp_path)
    (tmp_path / "robot.yaml").write_text(text)
    again = Robot.load(str(tmp_path / "robot.yaml"))
    assert (again.joints, again.tool, again.home.tolist()) == (robot.joints, robot.tool, robot.home.tolist())
    assert again.disabled_pairs == pairs
    assert "# joined by one joint" in text


@pytest.mark.parametrize("touches", [True, False])
def test_pairs_in_the_way_are_named(urdf_file, touches: bool) -> None:
    """A bar turns about z, over a disc that is wide enough or not."""
    links = link_xml("a") + link_xml("b", '<box size="0.02 0.02 0.02"/>', origin='<origin xyz="0.5 0 0"/>')
    links += link_xml("disc", f'<cylinder radius="{0.55 if touches else 0.4}" length="0.01"/>') + link_xml("m")
    joints = joint_xml("j", "a", "b", limit="-3 3") + joint_xml("weld", "a", "m", "fixed")
    robot = Robot.load(urdf_file(links + joints + joint_xml("k", "m", "disc")), tool="b")
    summary, *pairs = self_test(CoalChecker(World.from_scene(robot, Scene("none"), frozenset())))
    home, reached, free = ("in collision", 0, 0) if touches else ("free", 8, 100)
    assert f"home is {home}, {reached} of 8 tool positions are reached, {free} % of" in summary
    assert len(pairs) == touches
    assert all("'b' and 'disc' touch at home and in 100 % of random configurations:" in pair for pair in pairs)
