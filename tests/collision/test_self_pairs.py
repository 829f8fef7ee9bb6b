"""Which pairs of links are not checked."""

from dataclasses import replace

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.coal import CoalChecker
from planner.collision.fcl import FclChecker
from planner.collision.self_pairs import ALWAYS, adjacent_pairs, generate_disabled_pairs
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from tests.coal_judge import CoalWorld
from tests.worlds import ROBOTS, checker_of, joint_xml, link_xml, load, random_q

GENERATED = [name for name in ROBOTS if load(name).disabled_pairs is None]


@pytest.mark.parametrize("name", GENERATED)
def test_generated_pairs(name):
    """Neighbours are off, and whatever is still checked is not touching in nearly every configuration."""
    robot = load(name)
    world = checker_of(name).world
    checked = {frozenset((robot.bodies[i].link, robot.bodies[k].link)) for i, k in world.self_pairs}
    assert not checked & adjacent_pairs(robot)
    judge, q = CoalWorld(world), random_q(robot, 25, seed=11)
    touching = np.mean([judge.distances(row) <= 0 for row in q], axis=0)
    assert (touching < ALWAYS).all()


@pytest.mark.parametrize("name", ROBOTS)
def test_every_robot_is_free_at_home_and_can_hit_itself(name):
    checker = checker_of(name)
    assert checker.first_contact(load(name).home[None]) is None
    assert len(checker.world.self_pairs)


def test_a_pedestal_and_links_that_are_held_can_be_hit(urdf_file):
    """Pinocchio's frames and coal: the first moving link meets both, which hang on the base."""
    ball, post = '<sphere radius="0.02"/>', '<box size="0.1 0.1 0.1"/>'
    rod = '<capsule radius="0.02" length="0.5"/>'
    file = urdf_file(
        link_xml("base", ball) + link_xml("mount") + link_xml("pedestal", post) + link_xml("arm", ball)
        + link_xml("rod", rod)
        + joint_xml("stand", "base", "pedestal", "fixed", xyz="0 0 0.4")
        + joint_xml("m", "base", "mount", "fixed")
        + joint_xml("j1", "mount", "arm", "revolute", "0 1 0", limit="-3 3", xyz="0.3 0 0.4")
        + joint_xml("j2", "arm", "rod", "revolute", "0 1 0", limit="-3 3", xyz="-0.1 0 0")
    )  # fmt: skip
    whole, held = Robot.load(file, tool="rod"), Robot.load(file, tool="rod", fixed_joints={"j1": 0.0})
    assert adjacent_pairs(whole) == {frozenset(("base", "arm")), frozenset(("arm", "rod"))}
    assert adjacent_pairs(held) == {frozenset(("arm", "rod"))}
    for robot in (whole, held):
        assert frozenset(("pedestal", "rod")) not in generate_disabled_pairs(robot, FclChecker)
        world = make_checker(robot, Scene("none")).world
        judge, q = CoalWorld(world), random_q(robot, 200, seed=3)
        hits = np.array([judge.distances(row).min() <= 0 for row in q])
        assert hits.any()
        checker = make_checker(robot, Scene("none"))
        assert [checker.first_contact(row[None]) is not None for row in q] == hits.tolist()


def test_whatever_the_backend_the_pairs_are_the_same_and_no_shapes_are_made_for_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Trees of triangles take longer than all the rest."""
    monkeypatch.setattr("planner.collision.fcl._geometry", lambda shape: pytest.fail("a shape is made"))
    robot = replace(load("kinova"), upper=load("kinova").upper - 0.0321)
    assert generate_disabled_pairs(robot, FclChecker) == generate_disabled_pairs(robot, CoalChecker)
