"""Checks of a path against coal's distances, dense looks and planted faults."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from planner.base.errors import OptionError
from planner.collision import make_checker
from planner.collision.checker import is_free
from planner.collision.edge_prover import Verdict
from planner.kinematics.manipulability import manipulability
from planner.planning.result import Plan
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.shapes import Box
from planner.trajectory.path_check import check_path, prove_path, worst_excess
from planner.trajectory.path_clearance import slack, smallest_clearance
from planner.trajectory.path_report import report_record, report_rows, verdict_sentence
from tests.coal_judge import CoalWorld
from tests.worlds import checker_of, joint_xml, link_xml, load, scene_of


def test_proofs_keep_their_distance(solved: Plan) -> None:
    """What a path is proven to keep is kept, by coal's distances at places in between."""
    report = check_path(solved.checker, solved.path)
    assert report.ok
    assert report.proven.count(Verdict.FREE) == len(solved.path) - 1
    assert report.clearance is not None
    assert report.proven.bound is not None
    assert 0.0 < report.proven.bound <= report.clearance.value
    assert report.proven.bound >= 0.4 * report.clearance.value
    coal = CoalWorld(solved.checker.world)
    moved = np.flatnonzero(solved.checker.world.pair_reach.any(axis=1))
    q = np.concatenate([a + np.linspace(0, 1, 25)[:, None] * (b - a) for a, b in itertools.pairwise(solved.path)])
    assert min(coal.distances(each, moved).min() for each in q) >= report.proven.bound
    assert verdict_sentence(report) == "Free and within limits; every segment is proven free as a whole."


def test_manipulability_and_where(solved: Plan) -> None:
    report = check_path(solved.checker, solved.path)
    low = report.lowest
    a, b = solved.path[low.segment : low.segment + 2]
    np.testing.assert_allclose(a + low.share * (b - a), low.q, atol=1e-9)
    assert manipulability(solved.robot, low.q)[0] == pytest.approx(report.w.min())
    dense = np.concatenate([p + np.linspace(0, 1, 400)[:, None] * (q - p) for p, q in itertools.pairwise(solved.path)])
    assert report.w.min() == pytest.approx(manipulability(solved.robot, dense).min(), rel=0.02, abs=1e-5)


def test_a_planted_collision_is_found_first(solved: Plan) -> None:
    rng, robot = np.random.default_rng(0), solved.robot
    bad = next(q for q in rng.uniform(robot.lower, robot.upper, (200, 7)) if not is_free(solved.checker, q))
    path = np.vstack([solved.path[:2], bad, solved.path[2:]])
    report = check_path(solved.checker, path)
    assert not report.ok
    assert report.contact is not None
    assert report.contact.segment in (1, 2)
    assert not is_free(solved.checker, report.contact.q)
    assert report.proven.bound is None
    assert report.clearance is not None
    assert report.clearance.value == 0.0
    sentence = verdict_sentence(report)
    assert sentence.startswith("Not usable: '")
    assert str(report.contact.contact) in sentence


def test_proofs_see_what_looks_pass_by() -> None:
    """A thin wall between two looks half a metre apart."""
    checker = make_checker(load("planar_2r"), scene_of((Box((0.4, 0.001, 0.4)), pose([0.7, 0, 0]))))
    path = np.array([[-0.12, 0.0], [0.11, 0.0]])
    report = check_path(checker, path, step=0.5)
    assert report.contact is None
    assert report.proven.strikes is not None
    assert not report.ok
    assert "between two samples at every 500 mm" in verdict_sentence(report)
    assert report_record(report)["contact"]["pair"][1] == "thing0"
    assert check_path(checker, path, step=0.001).contact is not None


def test_a_path_that_grazes_is_undecided_not_proven() -> None:
    checker = make_checker(load("planar_2r"), scene_of((Box((0.02, 0.02, 0.02)), pose([0.6, 0.0, 0.0]))), margin=0.0)
    path = np.array([[0.3, 0.0], [0.6, 0.0]])
    found = smallest_clearance(checker, path)
    assert found is not None
    tight = make_checker(load("planar_2r"), checker.world.scene, margin=found.value - 5e-6)
    report = check_path(tight, path)
    assert report.ok
    assert report.proven.count(Verdict.UNDECIDED) == 1
    assert verdict_sentence(report).endswith("1 segment could not be proven.")


def test_limits(solved: Plan) -> None:
    robot, path = solved.robot, np.array(solved.path)
    path[2, 3] = robot.upper[3] + 0.2
    path[1, 5] = robot.lower[5] - 0.1
    excess = worst_excess(robot, path)
    assert excess is not None
    assert (excess.row, excess.joint) == (2, robot.joints[3])
    assert excess.beyond == pytest.approx(0.2)
    report = check_path(solved.checker, path)
    assert not report.ok
    assert "waypoint 3 puts joint 'iiwa14_joint_4'" in verdict_sentence(report)
    assert (report.proven.verdicts[:3] == Verdict.UNDECIDED).all()
    assert worst_excess(robot, np.array([robot.lower, robot.upper])) is None


def test_sliding_joints_beyond_their_limits_are_not_proven(urdf_file) -> None:
    """Their reach is known within limits only."""
    inside = link_xml("a") + link_xml("b", '<box size="0.1 0.1 0.1"/>') + joint_xml("slide", "a", "b", "prismatic")
    robot = Robot.load(urdf_file(inside))
    checker = make_checker(robot, scene_of((Box((0.1, 0.1, 0.1)), pose([1.0, 0, 0]))))
    path = np.array([[0.0], [0.5], [3.0]])
    report = check_path(checker, path)
    assert report.proven.verdicts.tolist() == [Verdict.FREE, Verdict.UNDECIDED]
    assert "m outside [-1, 1]" in verdict_sentence(report)


def test_one_configuration_and_an_empty_world() -> None:
    checker = checker_of("planar_2r")
    report = check_path(checker, np.array([[0.1, 0.2]]))
    assert report.ok
    assert report.clearance is None or report.clearance.value > 0
    assert dict(report_rows(report))["path"].startswith("1 waypoint, 0.000 rad")
    alone = prove_path(checker, np.array([[0.1, 0.2]]))
    assert len(alone.verdicts) == 0


def test_both_backends_agree(solved: Plan) -> None:
    coal = make_checker(solved.robot, solved.scene, backend="coal")
    first, second = check_path(solved.checker, solved.path), check_path(coal, solved.path)
    assert first.ok
    assert second.ok
    assert first.clearance is not None
    assert second.clearance is not None
    larger = max(first.clearance.value, second.clearance.value)
    assert first.clearance.value == pytest.approx(second.clearance.value, abs=slack(larger) + 2e-4)
    wide = type(coal)(replace(coal.world, margin=first.clearance.value + 0.01))
    assert not check_path(wide, solved.path).ok


@pytest.mark.parametrize("step", [0.0, -1.0, np.nan, np.inf, 2.0])
def test_a_step_that_is_none(step: float) -> None:
    with pytest.raises(OptionError, match="is not usable"):
        check_path(checker_of("planar_2r"), np.zeros((2, 2)), step)


def test_a_finely_divided_path_costs_no_more_distances(solved: Plan) -> None:
    """A trajectory has thousands of rows: looking at each of them for its clearance took longer than all the rest."""
    shares = np.linspace(0.0, 1.0, 400, endpoint=False)[:, None]
    path = np.concatenate([a + shares * (b - a) for a, b in itertools.pairwise(solved.path)])
    checker = make_checker(solved.robot, solved.scene)
    before = solved.checker.queries
    coarse, fine = check_path(solved.checker, solved.path), check_path(checker, path)
    assert fine.ok
    assert checker.queries < 1.5 * (solved.checker.queries - before)
    assert coarse.clearance is not None
    assert fine.clearance is not None
    larger = max(coarse.clearance.value, fine.clearance.value)
    assert fine.clearance.value == pytest.approx(coarse.clearance.value, abs=slack(larger) + 2e-4)
