"""Plans of a robot with two arms: goals of both tools, and a tray that both carry, judged by Pinocchio and coal."""

import itertools

import numpy as np
import pinocchio as pin
import pytest

import planner
from planner.base.errors import PlannerError
from planner.cli.app import run
from planner.collision.checker import contact_at
from planner.problem.conditions import keep_pose, read_conditions
from tests.coal_judge import CoalWorld
from tests.two_arms import load_two_arms, two_arms

GOAL = "left_tool xyz:0.35,0.1,0.85 & right_tool xyz:0.3,-0.3,0.5"
BOX = planner.Obstacle("post", planner.Box((0.06, 0.06, 1.2)), planner.pose([0.35, -0.1, 0.4]))
TOGETHER = "keep:0.02,0.1 of right_tool in left_tool"


def placed(robot, q, frame):
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    return data.oMf[robot.model.getFrameId(frame, pin.FrameType.BODY)].copy()


def touches(plan):
    judge = CoalWorld(plan.checker.world)
    path = zip(plan.path[:-1], plan.robot.difference(plan.path[:-1], plan.path[1:]), strict=True)
    return min(judge.nearest_along(start, delta, 0.03, 0.001) for start, delta in path) <= 0.0


@pytest.fixture(scope="module")
def both():
    urdf, srdf = two_arms()
    how = {"srdf": srdf, "group": "both", "start": "low", "goal": GOAL, "nodes": 150, "refinement_rounds": 2}
    return planner.plan(str(urdf), planner.Scene("post", (BOX,)), **how, timing=None)


def test_both_tools_reach_their_goals_past_a_post(both):
    robot, end = both.robot, both.path[-1]
    np.testing.assert_allclose(placed(robot, end, "left_tool").translation, [0.35, 0.1, 0.85], atol=2e-6)
    np.testing.assert_allclose(placed(robot, end, "right_tool").translation, [0.3, -0.3, 0.5], atol=2e-6)
    assert not touches(both)


def test_w_of_each_tool_is_in_the_record(both):
    record = both.to_dict()
    w, each = record["manipulability"], {one["frame"]: one for one in record["manipulability"]["tools"]}
    assert record["tool"] == w["frame"] == "left_tool,right_tool"
    assert w["min"] == min(one["min"] for one in each.values())
    assert w["mean"] <= min(one["mean"] for one in each.values())
    left = load_two_arms("left_tool").manipulability(both.path)
    assert each["left_tool"]["min"] <= left.min() + 1e-12
    text = dict(both.record.rows)["manipulability w"]
    assert all(f"{one['min']:.5f} of {name}" in text for name, one in each.items())


def dense(path):
    s = np.linspace(0.0, 1.0, 50)[:, None]
    return np.concatenate([a + s * (b - a) for a, b in itertools.pairwise(path)])


@pytest.fixture(scope="module")
def grips():
    """Configurations with both hands 0.3 m apart on a tray, which is at two places."""
    robot, found = load_two_arms(), []
    checker = planner.make_checker(robot, planner.Scene("none"))
    turned = pin.rpy.rpyToMatrix(0, np.pi / 2, 0)
    for x, z in ((0.35, 0.7), (0.42, 0.9)):
        poses = {f"{side}_tool": pin.SE3(turned, np.array([x, y, z])) for side, y in (("left", 0.15), ("right", -0.15))}
        q = robot.ik(poses, near=found[0] if found else None, starts=200)
        found.append(next(row for row in q if contact_at(checker, row) is None))
    return robot, found, poses["left_tool"]


def test_both_hands_carry_a_tray_on_the_whole_path_and_motion(grips):
    robot, (start, _), goal = grips
    how = {"start": start, "goal": goal, "nodes": 40, "refinement_rounds": 1}
    plan = planner.plan(robot, None, **how, constraint=TOGETHER)
    at_start = placed(robot, start, "left_tool").actInv(placed(robot, start, "right_tool"))
    for q in (*dense(plan.path), *plan.trajectory.at(np.linspace(0.0, plan.trajectory.duration, 500))):
        off = at_start.actInv(placed(robot, q, "left_tool").actInv(placed(robot, q, "right_tool")))
        assert np.linalg.norm(off.translation) <= 0.02 + 1e-6
        assert np.linalg.norm(pin.log3(off.rotation)) <= 0.1 + 1e-6
    np.testing.assert_allclose(placed(robot, plan.path[-1], "left_tool").homogeneous, goal.homogeneous, atol=1e-5)
    assert all(each["path_proven"] and each["motion_proven"] for each in plan.to_dict()["constraints"])
    alone = planner.plan(robot, None, start=start, goal=goal, path_only=True, timing=None)  # without it they part
    end = placed(robot, alone.path[-1], "left_tool").actInv(placed(robot, alone.path[-1], "right_tool"))
    assert np.linalg.norm(at_start.actInv(end).translation) > 0.02


def test_the_text_and_the_function_are_the_same_constraint():
    made = keep_pose(0.02, 0.1, frame="right_tool", base="left_tool")
    assert read_conditions(TOGETHER) == read_conditions(made) == made
    assert read_conditions("right_tool keep:0.02,0.1 in left_tool") == made
    assert read_conditions(";".join(each.text for each in made)) == made


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("keep:0.02 of right_tool", "must be keep:radius,angle"),
        ("keep:0.02,0.1 of right_tool in tray", "frame 'tray' not found"),
        ("keep:0.02,0.1 of right_tool in right_tip", "must leave 0.0001 m or more, got 0"),
        ("keep:0.02,0.1 of left_tool in left_link6", "no planned joint moves frame 'left_tool' in frame 'left_link6'"),
    ],
)
def test_a_constraint_that_cannot_be_kept_gets_one_sentence(text, said, grips):
    text = text.replace("0.02,0.1 of right_tool in right_tip", "0,0.1 of right_tool in right_link2")
    with pytest.raises(PlannerError, match=said):
        planner.plan(grips[0], None, start=grips[1][0], goal="home", constraint=text, path_only=True, timing=None)


def test_the_command_line_plans_for_both_tools_and_its_plan_loads_again(tmp_path, capsys):
    urdf, srdf = two_arms()
    how = ["--robot", str(urdf), "--srdf", str(srdf), "--joints", ",".join(load_two_arms().joints), "--scene", "empty"]
    how += ["--tool", "left_tool,right_tool", "--start", "low", "--goal", GOAL, "--path-only", "--no-timing"]
    assert run(["plan", *how, "--no-page", "--out", str(tmp_path)]) == 0
    loaded = planner.load(tmp_path)
    assert loaded.robot.tools == ("left_tool", "right_tool")
    assert GOAL.split(" & ")[0].split(" ")[0] in loaded.to_dict()["config"]["goal"]
    assert "left_tool" in capsys.readouterr().out
    assert run(["check", str(tmp_path)]) == 0
