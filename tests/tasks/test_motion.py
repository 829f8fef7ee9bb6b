"""Segments, events and motions of a task: looked at finely by another library, the object included."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import planner
from planner.collision import make_checker
from planner.collision.recheck import sample_contacts
from planner.cost.scale import COSTS, costs_along
from planner.kinematics.forward import tool_pose
from planner.problem.request import TimingRequest
from planner.robot.poses import pose
from planner.robot.robot import with_carried
from planner.robot.scene import Scene
from planner.robot.shapes import Carried, Obstacle, Sphere
from planner.tasks.check import check_task
from planner.tasks.plan import TaskPlanner, task
from planner.tasks.result import TaskPlan, _scene_in_motion
from planner.tasks.segments import Segment
from planner.tasks.task import Line, Pick
from planner.trajectory.trajectory import Trajectory
from tests.tasks.cases import BOARD, GRASPS, MUG, ON_BOARD, POST, SCENE, SMALL, TABLE, small
from tests.worlds import load

FINE = 1e-4  # m


@pytest.fixture(scope="module")
def plan() -> TaskPlan:
    return small().plan(timing=TimingRequest())


def motion_of(plan: TaskPlan, segment: Segment) -> Trajectory:
    """The part of the whole motion that a segment is."""
    whole, times = plan.trajectory, segment.trajectory
    assert whole is not None
    assert times is not None
    begin, end = round(1e9 * times.begin), round(1e9 * (times.begin + times.duration))
    rows = (whole.nanoseconds >= begin) & (whole.nanoseconds <= end)
    return Trajectory(whole.joints, whole.nanoseconds[rows], tuple(column[rows] for column in whole.columns))


def test_segments_follow_each_other_from_rest_to_rest(plan: TaskPlan) -> None:
    parts = [(segment.step, segment.part, segment.carried) for segment in plan.segments]
    assert parts == [
        (1, "transit", None),
        (1, "approach", None),
        (1, "retreat", "mug"),
        (2, "transit", "mug"),
        (2, "approach", "mug"),
        (2, "retreat", None),
        (3, "transit", None),
    ]
    for one, other in zip(plan.segments, plan.segments[1:], strict=False):
        np.testing.assert_array_equal(one.path[-1], other.path[0])
    for segment in plan.segments:
        times, whole = segment.trajectory, plan.trajectory
        assert times is not None
        assert whole is not None
        assert times.proven
        ends = times.begin + np.array([0.0, times.duration])
        np.testing.assert_allclose(whole.at(ends), segment.path[[0, -1]], atol=1e-9)
        assert np.abs(whole.at(ends, 1)).max() < 1e-9


def test_events_stand_at_rests_of_the_whole_motion(plan: TaskPlan) -> None:
    whole = plan.trajectory
    assert whole is not None
    assert whole.proven
    assert [event.kind for event in plan.events] == ["gripper", "attach", "detach", "gripper"]
    for event in plan.events:
        assert event.t is not None
        assert np.abs(whole.at(event.t, 1)).max() < 1e-9
    closed, opened = plan.events[0].joints, plan.events[-1].joints
    assert closed == pytest.approx({"panda_finger_joint1": 0.03, "panda_finger_joint2": 0.03})
    assert opened == pytest.approx({"panda_finger_joint1": 0.04, "panda_finger_joint2": 0.04})
    rests = sum(segment.trajectory.duration for segment in plan.segments if segment.trajectory)
    assert whole.duration == pytest.approx(rests + 2 * 0.5)


def test_nothing_touches_every_tenth_of_a_millimetre(plan: TaskPlan) -> None:
    """Worlds built anew from the events, coal in the place of proofs; the mug misses the table once it is off it."""
    robot = load("panda")
    attach, detach = (next(e for e in plan.events if e.kind == kind) for kind in ("attach", "detach"))
    assert plan.trajectory is not None
    at = {e.kind: tool_pose(robot, plan.trajectory.at(e.t or 0.0)[0]).homogeneous for e in (attach, detach)}
    hold = np.linalg.inv(at["attach"]) @ MUG.placement
    put = at["detach"] @ hold
    touch = frozenset(frozenset(("mug", link)) for link in ("panda_leftfinger", "panda_rightfinger"))
    for segment in plan.segments:
        fixed = (TABLE, BOARD, POST)
        if segment.carried:
            holding = with_carried(robot, [Carried(robot.tool, "mug", MUG.shape, hold)])
            judge = make_checker(holding, Scene("x", fixed), "coal")
        else:
            mug = MUG if segment.step == 1 else Obstacle("mug", MUG.shape, put)
            allowed = touch if segment.part != "transit" else frozenset()
            judge = make_checker(robot, Scene("x", (*fixed, mug), allowed=allowed), "coal")
        made = motion_of(plan, segment)
        contact = sample_contacts(judge, made.coefficients, FINE)
        if segment.part == "retreat" and segment.carried and contact is not None:
            # it stands on the table, and is lifted off it
            assert {contact.contact.first, contact.contact.second} == {"mug", "table"}
            later = made.at(made.times[0] + np.linspace(0.3 * made.duration, made.duration, 2000))
            assert judge.first_contact(later) is None
            continue
        assert contact is None, segment


def test_check_sees_what_only_the_object_touches(plan: TaskPlan) -> None:
    robot, carrying = load("panda"), plan.segments[3]
    attach = plan.segments[1].path[-1]
    hold = np.linalg.inv(tool_pose(robot, attach).homogeneous) @ MUG.placement
    made = motion_of(plan, carrying)
    mug = tool_pose(robot, made.at(made.times[0] + 0.5 * made.duration)[0]).homogeneous @ hold
    bead = Obstacle("bead", Sphere(0.01), pose(tuple(mug[:3, 3] - 0.1 * mug[:3, 2])))
    checker = make_checker(robot, replace(SCENE, obstacles=(*SCENE.obstacles, bead)))
    record = plan.record
    (finding,) = check_task(record, checker, plan.trajectory).findings
    assert finding.what == ("mug", "bead")


def test_the_page_moves_the_object_with_the_hand(plan: TaskPlan) -> None:
    assert plan.trajectory is not None
    (mug,) = _scene_in_motion(plan, plan.trajectory).moving
    attach, detach = (event.t for event in plan.events if event.kind in ("attach", "detach"))
    assert attach is not None
    assert detach is not None
    np.testing.assert_allclose(mug.motion.at(0.5 * attach)[0], MUG.placement, atol=1e-9)
    robot = load("panda")
    hold = np.linalg.inv(tool_pose(robot, plan.trajectory.at(attach)[0]).homogeneous) @ MUG.placement
    for t in np.linspace(attach, detach, 37):
        carried = tool_pose(robot, plan.trajectory.at(t)[0]).homogeneous @ hold
        np.testing.assert_allclose(mug.motion.at(t)[0], carried, atol=2e-3)
    np.testing.assert_allclose(mug.motion.at(plan.trajectory.duration)[0][2], [0, 0, 1, 0.341], atol=1e-4)
    assert "mug move:" not in plan.page(), "the page warns of the object that it draws in motion"


def test_a_margin_is_kept_but_where_the_object_rests() -> None:
    found = task(SMALL, timing=TimingRequest(), nodes=100, ik_solutions=2, margin=0.008)
    assert found.solved, found.message
    assert found.trajectory is not None
    assert found.trajectory.proven
    report = planner.check(found)
    assert report.ok
    assert {part.checker.world.margin for part in report.parts} == {0.008}


def test_lines_that_end_where_the_object_may_still_touch_are_timed_and_judged() -> None:
    place = replace(ON_BOARD, approach=Line(0.004), retreat=Line(0.004))
    short = replace(SMALL, steps=(Pick("mug", GRASPS, Line(0.004), Line(0.004)), place))
    found = task(short, timing=TimingRequest(), nodes=200, ik_solutions=2)
    assert found.trajectory is not None, found.message
    assert found.trajectory.proven
    assert planner.check(found).ok


def test_coal_finds_what_fcl_finds() -> None:
    one, two = (task(SMALL, nodes=60, ik_solutions=1, collision=kind, timing=None) for kind in ("fcl", "coal"))
    assert one.cost is not None
    assert one.cost == two.cost


@pytest.mark.parametrize("beta", [0.0, 0.5, 1.0])
def test_the_waypoints_cost_what_the_plan_says(beta: float) -> None:
    """Each piece of the path by itself, measured anew: they are the motions that the field has chosen."""
    found = small().plan(beta=beta)
    assert found.roadmap is not None
    assert found.cost is not None
    for one, other in itertools.pairwise(found.segments):
        np.testing.assert_allclose(one.path[-1], other.path[0], atol=1e-12)
    delta = np.concatenate([np.diff(segment.path, axis=0) for segment in found.segments])
    start = np.concatenate([segment.path[:-1] for segment in found.segments])
    scale = found.roadmap.scale
    distance = np.maximum(np.linalg.norm(delta, axis=1) / scale.joint_length, scale.zeta)
    omega = costs_along(found.robot, start, delta, scale)[1][:, COSTS.index("log")] * distance
    assert found.cost.distance == pytest.approx(distance.sum(), rel=1e-9)
    assert found.cost.manipulability == pytest.approx(omega.sum(), rel=1e-9)


def test_what_the_scene_keeps_is_kept_by_every_segment() -> None:
    """A mug that is never tilted by more than half a rad: not by the slanting grasp either."""
    task = replace(SMALL, scene=replace(SCENE, constraints="axis:z,0,0,-1,0.5"))
    plan = TaskPlanner.from_task(task, nodes=200, ik_solutions=2).plan(timing=TimingRequest())
    assert plan.solved
    assert plan.trajectory is not None
    t = np.linspace(0.0, plan.trajectory.duration, 2000)
    axis = np.array([tool_pose(plan.robot, q).rotation[:, 2] for q in plan.trajectory.at(t)])
    assert np.arccos(np.minimum(-axis[:, 2], 1.0)).max() <= 0.5 + 1e-9
    assert planner.check(plan).ok
