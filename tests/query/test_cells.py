"""States of single robots of a cell as configurations of its composite, planned and checked by the usual commands."""

from pathlib import Path

import numpy as np
import pytest

import planner
from planner.base.errors import OptionError, PlannerError
from planner.certificate import verify
from planner.certificate.verify_proof import Refused
from planner.collision.recheck import sample_along
from planner.problem.targets import RobotStates, parse_target, read_goals, read_target
from planner.robot.cell import Cell
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from tests.coal_judge import CoalWorld
from tests.robot.test_cell import TWO_ARMS

Q = [0.8, 0.4]


def two_planar_arms() -> Cell:
    arm = Robot.load("planar_2r")
    return Cell("pair", {"a": arm, "b": Robot.load("planar_2r", base=pose([1.6, 0, 0], [0, 0, np.pi]))})


def test_texts_and_mappings_name_a_robot() -> None:
    start = read_target("a:q:0.8,0.4;b:home")
    assert isinstance(start, RobotStates)
    assert start == parse_target(start.text) == read_target({"a": Q, "b": "home"})
    assert [goal.text for goal in read_goals("a:xyz:1,0,0;b:home")] == ["a:xyz:1,0,0", "b:home"]
    for text in ("a:", ":home", "a b:home", "a:b:home"):
        with pytest.raises(OptionError, match="state must be"):
            parse_target(text)


def test_a_robot_without_a_goal_stays_and_the_motion_is_free_by_coal(tmp_path: Path) -> None:
    cell = two_planar_arms()
    plan = planner.plan(cell=cell, start={"a": [1.0, 0.3]}, goal={"a": [-1.0, -0.3]}, nodes=60)
    assert plan.solved
    assert plan.trajectory is not None
    assert plan.trajectory.proven
    assert np.allclose(plan.path[[0, -1]][:, :2], [[1.0, 0.3], [-1.0, -0.3]])
    assert np.allclose(plan.path[[0, -1]][:, 2:], cell.robots["b"].home)
    judge, looks = CoalWorld(plan.checker.world), sample_along(plan.checker, plan.trajectory.coefficients, 0.02)
    for t in np.linspace(0, plan.trajectory.duration, 100):
        assert (judge.distances(plan.trajectory.at(t)[0])[plan.checker.world.moving] > 0).all()
    assert len(looks.s)


def test_a_cell_file_is_planned_saved_and_checked(tmp_path: Path) -> None:
    plan = planner.plan(cell=TWO_ARMS, start="here", goal="there", path_only=True, collision="coal")
    assert plan.trajectory is not None
    assert plan.trajectory.proven
    plan.save(tmp_path)
    assert plan.record.config["cell"] == str(TWO_ARMS)
    assert "robot" not in plan.record.config
    report = planner.check(tmp_path)
    assert report.proven
    assert report.checker.robot.joints == Cell.load(TWO_ARMS).robot.joints
    loaded = planner.Plan.load(tmp_path)
    assert np.allclose(loaded.path, plan.path)


def test_a_session_plans_for_a_cell() -> None:
    session = planner.Session(cell=two_planar_arms(), nodes=60)
    plan = session.plan({"a": [1.0, 0.3]}, {"a": [-1.0, -0.3], "b": "home"}, timing=None)
    assert plan.solved
    assert np.allclose(plan.path[-1], [-1.0, -0.3, *session.robot.home[2:]])


REFUSED = {
    "robot too": (dict(robot="panda", goal={"a": Q}), "leave out --robot"),
    "unknown robot": (dict(goal={"c": Q}), "robot 'c' not found"),
    "unknown state": (dict(goal={"a": "nowhere"}), "goal 'nowhere' not found; states of a in the scene"),
    "no goal": (dict(), "goal 'goal' not found"),
    "both kinds": (dict(goal=["home", {"a": Q}]), "must be ROBOT:STATE for each robot, or one state of all"),
    "a pose of all": (dict(start="xyz:1,0,0", goal={"a": Q}), "start must be ROBOT:STATE"),
    "touching": (dict(start={"a": [0.0, 0.0], "b": [0.0, 0.0]}, goal={"a": Q}), "start is in collision"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_bad_states_get_one_sentence(case: str) -> None:
    options, words = REFUSED[case]
    with pytest.raises(PlannerError) as caught:
        planner.plan(cell=two_planar_arms(), nodes=50, **options)
    assert words in str(caught.value)


def test_states_by_robot_need_a_cell() -> None:
    with pytest.raises(OptionError, match="--cell for states by robot"):
        planner.plan("planar_2r", "empty", start="a:home", goal=Q)


def test_robots_whose_bases_touch_are_refused() -> None:
    near = Robot.load("panda", base=pose([0.1, 0, 0]))
    cell = Cell("near", {"a": Robot.load("panda"), "b": near}, Scene("near"))
    with pytest.raises(PlannerError, match="must stand apart, got a contact of 'panda_link0' and 'b_panda_link0"):
        planner.plan(cell=cell, goal={"a": "home"})


def test_a_certificate_of_a_composite_holds_and_one_of_another_cell_does_not(tmp_path: Path) -> None:
    cell = two_planar_arms()
    plan = planner.plan(cell=cell, start={"a": [1.0, 0.3]}, goal={"a": [-1.0, -0.3]}, nodes=60)
    plan.save(tmp_path, certificate=True)
    assert "cell 'pair'" in verify(tmp_path, plan.checker.world)
    nearer = Cell("pair", {**cell.robots, "b": Robot.load("planar_2r", base=pose([1.5, 0, 0], [0, 0, np.pi]))})
    other = planner.plan(cell=nearer, start={"a": [1.0, 0.3]}, goal={"a": [0.9, 0.3]}, nodes=20, timing=None)
    with pytest.raises(Refused):
        verify(tmp_path, other.checker.world)
