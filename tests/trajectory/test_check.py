"""Paths and trajectories of any origin: against coal's distances, dense looks, planted faults and closed forms."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest

import planner
from planner.base.errors import ArrayError, FileError, OptionError
from planner.collision import make_checker
from planner.collision.checker import is_free
from planner.kinematics.manipulability import manipulability
from planner.planning.result import Plan
from planner.problem.request import LimitsRequest
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.shapes import Box
from planner.trajectory.check import check_path, check_trajectory
from planner.trajectory.limits import MotionLimits
from planner.trajectory.measure import slack, smallest_clearance
from planner.trajectory.report import Report
from planner.trajectory.timing import time_path
from tests.coal_judge import CoalWorld
from tests.worlds import joint_xml, link_xml, load, make_post, scene_of

ARM = load("planar_2r")
LIMITS = MotionLimits.from_robot(ARM)
# behind the arm's way from q1 = -0.6 to 0, and in that of a swing beyond 0.2
CHECKER = make_checker(ARM, scene_of((Box((0.1, 0.1, 0.1)), pose([0.75, 0.35, 0.0]))))
STILL = [[-0.3, 0.0], [-0.3, 0.0]]


def report_of(times: list[float], *columns: list[list[float]], limits: MotionLimits = LIMITS) -> Report:
    arrays = (np.array(rows, dtype=float) for rows in columns)
    motion = planner.Trajectory.from_points(ARM.joints, np.array(times), *arrays)
    return assert_plain(check_trajectory(CHECKER, motion, limits))


def assert_plain(report: Report) -> Report:
    """The record is plain data, and says the same as the report; so do the rows."""
    record = report.to_dict()
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    assert (record["ok"], record["message"]) == (bool(report), report.sentence)
    said = " ".join(text for _, text in report.rows())
    assert all(finding.sentence in said for finding in report.findings)
    assert report.ok or report.findings[0].sentence in report.sentence
    assert report.ok or not report.proven
    return report


def test_proofs_keep_their_distance(solved: Plan) -> None:
    """The distance that a path is proven to keep is kept, by coal's distances at places in between."""
    report = assert_plain(check_path(solved.checker, solved.path))
    assert report.ok
    assert report.proven
    assert report.pieces == {"free": len(solved.path) - 1, "collides": 0, "undecided": 0}
    assert report.clearance is not None
    bound = report.measures["proven_distance"]
    assert 0.4 * report.clearance.min <= bound <= report.clearance.min
    coal = CoalWorld(solved.checker.world)
    moved = np.flatnonzero(solved.checker.world.pair_reach.any(axis=1))
    q = np.concatenate([a + np.linspace(0, 1, 25)[:, None] * (b - a) for a, b in itertools.pairwise(solved.path)])
    assert min(coal.distances(each, moved).min() for each in q) >= bound
    assert report.sentence == "Free and within limits; every segment is proven free as a whole."


def test_manipulability_lengths_and_where(solved: Plan) -> None:
    report = check_path(solved.checker, solved.path)
    m, k = report.measures, int(report.measures["w_at"])
    a, b = solved.path[k : k + 2]
    assert manipulability(solved.robot, (a + (m["w_at"] - k) * (b - a))[None])[0] == pytest.approx(m["w_min"])
    dense = np.concatenate([p + np.linspace(0, 1, 400)[:, None] * (q - p) for p, q in itertools.pairwise(solved.path)])
    assert m["w_min"] == pytest.approx(manipulability(solved.robot, dense).min(), rel=0.02, abs=1e-5)
    length = solved.record.path_length
    assert length is not None
    assert m["joint_length"] == pytest.approx(length.joint)
    assert m["workspace_length"] == pytest.approx(length.workspace)


def test_a_planted_collision_is_found_first(solved: Plan) -> None:
    rng, robot = np.random.default_rng(0), solved.robot
    bad = next(q for q in rng.uniform(robot.lower, robot.upper, (200, 7)) if not is_free(solved.checker, q))
    path = np.vstack([solved.path[:2], bad, solved.path[2:]])
    report = assert_plain(check_path(solved.checker, path))
    (finding,) = report.findings
    assert finding.kind == "contact"
    (at, _), q = finding.where, finding.q
    assert q is not None
    k = min(int(at), len(path) - 2)
    assert k in (1, 2)
    np.testing.assert_allclose(q, path[k] + (at - k) * (path[k + 1] - path[k]), atol=1e-9)
    assert not is_free(solved.checker, q)
    assert report.measures["proven_distance"] is None
    assert report.clearance is not None
    assert report.clearance.min == 0.0
    assert all(f"'{name}'" in report.sentence for name in finding.what)


def test_proofs_see_what_looks_pass_by() -> None:
    """A thin wall between two looks half a metre apart."""
    checker = make_checker(load("planar_2r"), scene_of((Box((0.4, 0.001, 0.4)), pose([0.7, 0, 0]))))
    path = np.array([[-0.12, 0.0], [0.11, 0.0]])
    (finding,) = assert_plain(check_path(checker, path, step=0.5)).findings
    assert (finding.kind, finding.q, finding.what[1]) == ("contact", None, "thing0")
    assert "between two samples" in finding.sentence
    (finding,) = check_path(checker, path, step=0.001).findings
    assert finding.q is not None


def test_a_path_that_grazes_is_undecided_not_proven() -> None:
    checker = make_checker(load("planar_2r"), scene_of((Box((0.02, 0.02, 0.02)), pose([0.6, 0.0, 0.0]))), margin=0.0)
    path = np.array([[0.3, 0.0], [0.6, 0.0]])
    found = smallest_clearance(checker, path)
    assert found is not None
    tight = make_checker(load("planar_2r"), checker.world.scene, margin=found[0] - 1e-8)
    report = assert_plain(check_path(tight, path))
    assert (report.ok, report.proven, report.pieces["undecided"]) == (True, False, 1)
    assert "1 segment could not be proven" in report.sentence


def test_the_margin_is_a_clearance_that_is_too_small(solved: Plan) -> None:
    coal = make_checker(solved.robot, solved.scene, backend="coal")
    first, second = check_path(solved.checker, solved.path).clearance, check_path(coal, solved.path).clearance
    assert first is not None
    assert second is not None
    assert first.min == pytest.approx(second.min, abs=slack(max(first.min, second.min)) + 2e-4)
    wide = type(coal)(replace(coal.world, margin=first.min + 0.01))
    (finding,) = assert_plain(check_path(wide, solved.path)).findings
    assert finding.kind == "clearance"
    assert finding.value is not None
    assert 0.0 < finding.value <= first.min + 0.01 == finding.allowed


def test_limits_of_waypoints(solved: Plan) -> None:
    robot, path = solved.robot, np.array(solved.path)
    path[2, 3] = robot.upper[3] + 0.2
    path[1, 5] = robot.lower[5] - 0.1
    finding = assert_plain(check_path(solved.checker, path)).findings[0]
    assert (finding.kind, finding.what, finding.where) == ("limit", ("position", robot.joints[3]), (2.0, 2.0))
    assert (finding.value, finding.allowed) == (path[2, 3], robot.upper[3])
    assert "0.2 rad beyond its limit" in finding.sentence
    assert "at waypoint 3" in finding.sentence
    degrees = check_path(solved.checker, np.degrees(np.clip(path, robot.lower, robot.upper)))
    assert "degrees?" in degrees.sentence
    assert degrees.pieces == {}, "nothing else is looked at: it would take minutes"


def test_sliding_joints_beyond_their_limits_are_not_proven(urdf_file) -> None:
    """Their reach is known within limits only."""
    inside = link_xml("a") + link_xml("b", '<box size="0.1 0.1 0.1"/>') + joint_xml("slide", "a", "b", "prismatic")
    robot = Robot.load(urdf_file(inside))
    checker = make_checker(robot, scene_of((Box((0.1, 0.1, 0.1)), pose([1.0, 0, 0]))))
    report = check_path(checker, np.array([[0.0], [0.5], [3.0]]))
    assert report.pieces["free"] == 1
    assert "2 m beyond its limit of 1," in report.sentence


def test_one_function_checks_paths_trajectories_and_plans(solved: Plan) -> None:
    path = [[-1.0, 0.5], [-0.6, -0.4], [-0.2, 0.1]]
    made = time_path(np.array(path), CHECKER)
    straight, timed = planner.check(path, checker=CHECKER), planner.check(made, checker=CHECKER)
    assert straight.proven
    assert timed.proven
    assert timed.sentence.startswith("Free and within all limits")
    touching = planner.check([[-1.0, 0.5], [0.8, 0.0]], checker=CHECKER)
    assert not touching.ok
    assert not touching
    assert len(repr(touching)) < 300
    assert planner.check(path, robot="planar_2r", scene="empty", margin=0.01).checker.world.margin == 0.01
    slower = MotionLimits.from_robot(ARM, LimitsRequest(velocity_scale=0.1))
    assert not planner.check(replace(made, limits=slower), checker=CHECKER).ok
    assert not planner.check(made, limits=slower, checker=CHECKER).ok
    assert planner.check(path, robot="planar_2r", scene="empty").ok
    assert planner.check(path, robot="planar_2r", scene=None).checker.world.scene.name == "empty"
    assert planner.check(solved).proven
    assert planner.check(solved.path, robot="iiwa14", scene="empty").ok
    for scene in ("empty", None):
        with pytest.raises(OptionError, match="those of the plan"):
            planner.check(solved, scene=scene)
    with pytest.raises(OptionError, match="joints of the trajectory must be"):
        planner.check(replace(made, joints=("a", "b")), checker=CHECKER)
    with pytest.raises(ArrayError, match="path"):
        planner.check([[1.0, 2.0, 3.0]], checker=CHECKER)


def test_points_that_are_free_and_a_curve_between_them_that_touches() -> None:
    """Each point, and the line between them, is free; the cubic that the velocities make swings into the box."""
    assert report_of([0.0, 4.0], STILL).ok
    times, columns = [0.0, 4.0, 4.5], ([*STILL, STILL[0]], [[1.2, 0.0], [0.0, 0.0], [0.0, 0.0]])
    swings = report_of(times, *columns)
    (finding,) = swings.findings
    motion = planner.Trajectory.from_points(ARM.joints, np.array(times), *map(np.array, columns))
    t = np.linspace(0.0, 4.0, 201)
    free = np.array([CHECKER.first_contact(row) is None for row in motion.at(t)])
    assert abs(finding.where[0] - t[~free][0]) < 0.05
    assert finding.q is not None
    np.testing.assert_allclose(finding.q, motion.at(finding.where[0])[0], atol=1e-9)


LINES = ([0.0, 1.0, 2.0], [[-0.3, 0.0], [-0.3, 0.5], [-0.3, 0.5]])
FAULTS = {
    "of velocity": ([0.0, 0.1], [[-0.6, 0.0], [-0.3, 0.0]]),
    "of acceleration": ([0.0, 0.4], [[-0.6, 0.0], [-0.3, 0.0]], [[0.0, 0.0], [0.0, 0.0]]),
    "of velocity ": ([0.0, 2.0], [[-0.6, 0.0], [-0.6, 0.0]], [[0.0, 3.3], [0.0, 0.0]]),
    "the last velocity is not 0": ([0.0, 1.0], [[-0.6, 0.0], [-0.3, 0.0]], [[0.0, 0.0], [5e-7, 0.0]]),
    "before the start": ([-1.0, 1.0], [[-0.6, 0.0], [-0.3, 0.0]]),
    "degrees": ([0.0, 90.0], [[-0.6, 0.0], [-0.6, 80.0]]),
    "beyond its limit": ([0.0, 9.0], [[-0.6, 0.0], [-0.6, 4.0]]),
    "touch": ([0.0, 9.0], [[-0.3, 0.0], [1.0, 0.0]]),
}


@pytest.mark.parametrize("words", FAULTS)
def test_a_fault_is_named(words: str) -> None:
    report = report_of(*FAULTS[words])
    assert not report.ok
    assert words.strip() in report.sentence


@pytest.mark.parametrize(
    ("rows", "limits", "kind", "words"),
    [
        (LINES[1:], LimitsRequest(acceleration=5.0), "acceleration", "jumps by 0.5 rad/s at 1.000 s"),
        (
            ([[-0.3, 0.0], [-0.3, 0.2], [-0.3, 0.2]], [[0.0, 0.0]] * 3),
            LimitsRequest(jerk=500.0),
            "jerk",
            "(the largest of 2 jumps)",
        ),
    ],
    ids=["lines", "cubics"],
)
def test_a_jump_is_beyond_every_limit_that_is_given(rows: tuple, limits: LimitsRequest, kind: str, words: str) -> None:
    """A limit that is merely assumed does not judge it, and the report says so."""
    judged = report_of(LINES[0], *rows, limits=MotionLimits.from_robot(ARM, limits))
    assert words in judged.sentence
    assert f"an infinite {kind} where the limit is" in judged.sentence
    assert (judged.findings[0].kind, judged.findings[0].value) == ("discontinuity", None)
    left_open = report_of(LINES[0], *rows)
    assert left_open.ok
    assert not left_open.proven
    assert "all limits" not in left_open.sentence
    assert "not checked" in left_open.sentence
    assert "not checked" in dict(left_open.rows())[kind]
    assert left_open.measures["shares"][kind] is None
    assert kind in left_open.measures["not_judged"]


def test_how_it_begins_is_noted() -> None:
    assert "the motion to the first point, until 0.5 s" in report_of([0.5, 4.0], STILL).notes[0]
    moving = report_of([0.0, 4.0], STILL, [[0.0, 0.2], [0.0, 0.0]])
    assert "joint 'joint_2' starts at a velocity of 0.2" in dict(moving.rows())["note"]


def test_a_swing_beyond_all_reason_is_refused() -> None:
    """It would take forever to sample."""
    with pytest.raises(FileError, match="positions between 0 and 900 s must be at most"):
        report_of([0.0, 900.0], [[-0.6, 0.0], [-0.3, 0.0]], [[900.0, 0.0], [0.0, 0.0]])


def test_a_constraint_that_is_broken_is_a_finding() -> None:
    checker = make_checker(ARM, make_post().world.scene, constraint="box:-2,-2,-1,0.5,2,1")
    report = assert_plain(check_path(checker, np.array([[2.0, 0.5], [0.0, 0.0], [-2.0, 0.5]])))
    finding = next(each for each in report.findings if each.kind == "constraint")
    assert finding.value == pytest.approx(
        float(np.abs(checker.world.constraints.slacks(np.zeros((1, 2)))[0, 0])), rel=1e-2
    )
    assert finding.where[0] == pytest.approx(1.0, abs=0.02)
