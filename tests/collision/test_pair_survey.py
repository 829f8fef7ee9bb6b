"""Which pairs of links need no check: known robots, and the proofs against random configurations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planner.collision import pair_survey
from planner.collision.coal import CoalChecker
from planner.collision.pair_survey import Reason, survey_pairs
from planner.collision.world import World
from planner.kinematics.forward import Chain
from planner.kinematics.reach import Reach, pair_reach
from planner.models.robot import Robot, with_carried
from planner.models.scene import Scene
from planner.models.shapes import Carried, Sphere
from tests.coal_judge import CoalWorld
from tests.worlds import joint_xml, link_xml, load, random_q

BALL, BIT = '<sphere radius="0.1"/>', '<sphere radius="0.05"/>'


@pytest.fixture
def arm(urdf_file) -> Robot:
    """Balls a and b in one place; c hangs on b through a link without a body; d slides from c over the others."""
    links = link_xml("a", BALL) + link_xml("b", BALL) + link_xml("none") + link_xml("c", BIT) + link_xml("d", BIT)
    joints = joint_xml("j1", "a", "b", limit="-3 3") + joint_xml("j2", "b", "none", limit="-3 3", xyz="0.3 0 0")
    joints += joint_xml("weld", "none", "c", "fixed", xyz="0.2 0 0")
    joints += joint_xml("slide", "c", "d", "prismatic", "1 0 0", limit="-0.8 0")
    return Robot.load(urdf_file(links + joints), tool="d")


def test_every_reason(arm: Robot) -> None:
    found = survey_pairs(arm, CoalChecker, 400, 0)
    assert found.pairs(Reason.ADJACENT) == [("a", "b"), ("b", "c"), ("c", "d")]
    assert found.pairs(Reason.SOMETIMES) == [("a", "c"), ("a", "d"), ("b", "d")]
    assert found.pairs(Reason.APART) == []
    short = replace(arm, lower=np.array([-3.0, -1.0, -0.1]))
    short = replace(short, upper=np.array([3.0, 1.0, 0.0]))
    assert set(survey_pairs(short, CoalChecker, 400, 0).pairs(Reason.APART)) == {("a", "c"), ("a", "d"), ("b", "d")}


def test_what_always_touches(urdf_file) -> None:
    links = link_xml("a", BALL) + link_xml("b", BIT) + link_xml("c", BALL)
    joints = joint_xml("j", "a", "b", limit="-3 3") + joint_xml("k", "b", "c", limit="-3 3", xyz="0.05 0 0")
    found = survey_pairs(Robot.load(urdf_file(links + joints)), CoalChecker, 200, 0)
    assert found.pairs(Reason.ALWAYS) == [("a", "c")]


def test_pairs_that_the_robot_disables_are_not_looked_at(arm: Robot) -> None:
    known = replace(arm, disabled_pairs=frozenset({frozenset("ad")}))
    assert frozenset("ad") not in survey_pairs(known, CoalChecker, 100, 0).reasons


def test_two_joints_apart_are_no_neighbours_even_with_nothing_between(urdf_file) -> None:
    links = link_xml("a", BALL) + link_xml("none") + link_xml("b", BIT)
    joints = joint_xml("j", "a", "none", limit="-3 3", xyz="0.2 0 0") + joint_xml("k", "none", "b", xyz="0.15 0 0")
    found = survey_pairs(Robot.load(urdf_file(links + joints)), CoalChecker, 100, 0)
    assert found.pairs(Reason.SOMETIMES) == [("a", "b")]


@pytest.mark.parametrize("name", ["iiwa14", "xarm7"])
def test_no_motion_of_one_joint_changes_a_distance_by_more_than_the_reach_of_the_pair(name: str) -> None:
    robot, rng = load(name), np.random.default_rng(5)
    world = World.of(robot, Scene("none"), frozenset())
    judge = CoalWorld(world)
    bounds = np.array([pair_reach(robot, robot.bodies[i], robot.bodies[k]) for i, k in world.self_pairs])
    assert (bounds <= Reach.of(robot).relative(world.self_pairs) + 1e-12).all()
    for q in random_q(robot, 8, seed=6):
        step = rng.uniform(-0.5, 0.5, robot.dof)
        change = np.abs(judge.distances(q + step) - judge.distances(q))
        assert (change <= bounds @ np.abs(step) + 1e-5).all()


def test_what_is_proven_apart_never_touches() -> None:
    robot = replace(load("iiwa14"), disabled_pairs=frozenset())
    robot = replace(robot, bodies=robot.bodies[:4])
    found = survey_pairs(robot, CoalChecker, 100, 0)
    proven = {frozenset(pair) for pair in found.pairs(Reason.APART)}
    world = World.of(robot, Scene("none"), frozenset())
    links = [frozenset((robot.bodies[i].link, robot.bodies[k].link)) for i, k in world.self_pairs]
    rows = [k for k, pair in enumerate(links) if pair in proven]
    assert rows
    judge = CoalWorld(world)
    assert all((judge.distances(q)[rows] > 0).all() for q in random_q(robot, 200, seed=7))


def test_a_climb_finds_no_contact_of_what_is_proven_apart() -> None:
    """Meshes, and joints between: from the nearest of random configurations downhill by coal's distances."""
    robot = replace(load("xarm7"), disabled_pairs=frozenset())
    world = World.of(robot, Scene("none"), frozenset())
    proven = {frozenset(pair) for pair in survey_pairs(robot, CoalChecker, 200, 0).pairs(Reason.APART)}
    links = [frozenset((robot.bodies[i].link, robot.bodies[k].link)) for i, k in world.self_pairs]
    rows, rng = [k for k, pair in enumerate(links) if pair in proven], np.random.default_rng(8)
    assert rows
    for row in rows:
        judge = CoalWorld(world.only(np.arange(len(links)) == row))
        q = random_q(robot, 5, seed=9)
        far = [judge.distances(one)[0] for one in q]
        best, at = min(far), q[int(np.argmin(far))]
        for step in np.geomspace(0.5, 1e-3, 15):
            tried = np.clip(at + step * rng.normal(size=robot.dof), robot.lower, robot.upper)
            found = judge.distances(tried)[0]
            best, at = (found, tried) if found < best else (best, at)
        assert best > 0


def test_what_a_proof_decides_is_not_sampled_again(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = replace(load("iiwa14"), disabled_pairs=frozenset())
    robot, asked = replace(robot, bodies=robot.bodies[:5]), []
    go_on = pair_survey._Sampling.go_on

    def watched(self: pair_survey._Sampling, pairs: np.ndarray, until: int) -> None:
        asked.append((int(pairs.sum()), until))
        go_on(self, pairs, until)

    monkeypatch.setattr(pair_survey._Sampling, "go_on", watched)
    found = survey_pairs(robot, CoalChecker, 1200, 0)
    (first, few), (second, samples) = asked
    assert (few, samples, found.samples) == (1000, 1200, 1200)
    assert second <= first - len(found.pairs(Reason.APART)) < first


def test_proofs_share_one_budget_of_work_and_are_the_same_again(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = replace(load("iiwa14"), disabled_pairs=frozenset())
    robot = replace(robot, bodies=robot.bodies[:5])
    whole = survey_pairs(robot, CoalChecker, 100, 0)
    assert whole.pairs(Reason.APART)
    assert survey_pairs(robot, CoalChecker, 100, 0) == whole
    monkeypatch.setattr(pair_survey, "_WORK", 0)
    none = survey_pairs(robot, CoalChecker, 100, 0)
    assert none.pairs(Reason.APART) == []
    assert set(whole.pairs(Reason.APART)) <= set(none.pairs(Reason.NEVER))
    assert none.unchecked(trust_samples=True) == whole.unchecked(trust_samples=True)
    assert none.unchecked(trust_samples=False) < whole.unchecked(trust_samples=False)


def test_no_call_of_the_compiled_library_is_long() -> None:
    """Ctrl-C is heard between calls: a look at large meshes takes long, so few are taken at once."""
    robot = load("kinova")
    checker = CoalChecker(World.of(robot, Scene("none"), frozenset()))
    for pair in range(len(checker.world.self_pairs)):
        proof = pair_survey._Proof(checker, pair)
        assert proof._step * proof._price <= max(pair_survey._AT_ONCE, proof._price)
        assert proof._step >= 1


def test_what_an_arm_holds_does_not_make_it_another_arm() -> None:
    """Reaches of its own links are worked out once, whatever it carries: a task holds one thing in many grasps."""
    robot = load("panda")
    held = [with_carried(robot, [Carried(robot.tool, name, Sphere(0.02), np.eye(4))]) for name in ("one", "other")]
    first, second = robot.bodies[0], robot.bodies[-1]
    assert {id(pair_reach(each, first, second)) for each in (robot, *held)} == {id(pair_reach(robot, first, second))}
    assert Chain.of(held[0]) is Chain.of(robot) is Chain.of(with_carried(held[1], []))
    assert len(Reach.of(held[0]).bodies) == len(robot.bodies) + 1
