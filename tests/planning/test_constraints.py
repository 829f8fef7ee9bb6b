"""Plans that keep something all along: path and motion hold it by another judge; bad ends get one sentence."""

import itertools
import json
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import planner
from planner.base.errors import PlannerError
from planner.cli.app import run

UPRIGHT = 0.0872664626  # rad: 5 degrees
DOWN = f"axis:z,0,0,-1,{UPRIGHT}"


def tilt(robot, q, axis=2, down=(0.0, 0.0, -1.0)):
    """Degrees between an axis of the tool and a direction, by Pinocchio."""
    data, worst = robot.model.createData(), 0.0
    for row in q:
        pin.framesForwardKinematics(robot.model, data, row)
        z = data.oMf[robot.tool_id].rotation[:, axis]
        worst = max(worst, float(np.degrees(np.arctan2(np.linalg.norm(np.cross(z, down)), z @ np.array(down)))))
    return worst


def dense(path, count=400):
    s = np.linspace(0.0, 1.0, count)[:, None]
    return np.concatenate([a + s * (b - a) for a, b in itertools.pairwise(path)])


@pytest.fixture(scope="module")
def upright():
    return planner.plan(
        robot="panda", scene="shelf", start="home", goal="xyz:-0.4,-0.4,0.5", constraint=DOWN, path_only=True,
        timing=planner.TimingRequest(),
    )  # fmt: skip


def test_the_cup_stays_upright_on_path_and_in_motion(upright):
    free = planner.plan(
        robot="panda", scene="shelf", start="home", goal="xyz:-0.4,-0.4,0.5", path_only=True, timing=None
    )
    assert tilt(free.robot, dense(free.path)) > 10.0  # without being asked it does not
    assert tilt(upright.robot, dense(upright.path)) <= 5.0 + 1e-6
    made = upright.trajectory
    assert made.proven
    assert made.proof["kept"] == [DOWN]
    assert tilt(upright.robot, made.at(np.linspace(0.0, made.duration, 4000))) <= 5.0 + 1e-6


def test_a_roadmap_keeps_it_everywhere():
    plan = planner.plan(
        robot="panda",
        scene="empty",
        start="home",
        goal="xyz:-0.4,-0.4,0.5",
        constraint=DOWN,
        nodes=60,
        refinement_rounds=2,
        timing=None,
    )
    assert plan.solved
    roadmap = plan.roadmap
    assert len(roadmap.nodes) == 60
    a, b = roadmap.nodes[roadmap.edges.T]
    assert max(tilt(plan.robot, dense(np.array(pair), 20)) for pair in zip(a, b, strict=True)) <= 5.0 + 1e-6


def test_a_kept_roadmap_is_held_to_what_is_kept_now(tmp_path):
    free = planner.plan(
        robot="panda", scene="empty", start="home", goal="xyz:-0.4,-0.4,0.5", nodes=60, refinement_rounds=0, timing=None
    )
    free.save(tmp_path)
    how: dict[str, Any] = {"robot": "panda", "scene": "empty", "start": "home", "goal": "xyz:-0.4,-0.4,0.5"}
    plan = planner.plan(**how, roadmap=tmp_path / "roadmap.npz", constraint=DOWN, timing=None)
    assert plan.solved
    assert tilt(plan.robot, dense(plan.path)) <= 5.0 + 1e-6


@pytest.mark.parametrize("constraint", ["turn:0.02", "box:-0.7,-0.7,0.48,0.7,0.7,0.5", "axis:z,0,0,-1,0.005"])
def test_thin_conditions_are_kept_by_projection(constraint):
    start = "xyz:0.4,0.4,0.49 & turn:0,1,0,0,0"
    plan = planner.plan(
        robot="panda",
        scene="empty",
        start=start,
        goal="box:0.397,-0.403,0.487,0.403,-0.397,0.493",
        constraint=constraint,
        path_only=True,
        timing=None,
    )
    assert plan.solved
    (kept,) = plan.to_dict()["constraints"]
    assert kept["path_proven"]
    assert kept["path"] >= 0


def test_a_goal_may_leave_an_axis_free():
    goal = planner.ToolGoal(
        (planner.BoxConstraint((0.4, 0.4, 0.5), (0.4, 0.4, 0.5)), planner.AxisConstraint("z", (0.0, 0.0, -1.0), 0.05))
    )
    plan = planner.plan(
        robot="panda", scene="empty", start="home", goal=goal, path_only=True, ik_solutions=8, timing=None
    )
    assert plan.goal == "xyz:0.4,0.4,0.5 & axis:z,0,0,-1,0.05"
    goals = plan.roadmap.nodes[plan.roadmap.goals]
    assert len(goals) == 8
    assert tilt(plan.robot, goals) <= np.degrees(0.05) + 1e-6
    data = plan.robot.model.createData()
    turns = []
    for q in goals:
        pin.framesForwardKinematics(plan.robot.model, data, q)
        placed = data.oMf[plan.robot.tool_id]
        assert np.linalg.norm(placed.translation - [0.4, 0.4, 0.5]) <= 2e-6
        turns.append(np.degrees(np.arctan2(placed.rotation[1, 0], placed.rotation[0, 0])))
    assert np.ptp(turns) > 30.0  # spread over what is free


def test_a_scene_keeps_too_and_check_judges_it(tmp_path, capsys, upright):
    (tmp_path / "bar.yaml").write_text(f'name: bar\nobstacles: []\nconstraints: ["{DOWN}"]\n')
    path = tmp_path / "path.csv"
    np.savetxt(path, upright.path, delimiter=",")
    assert run(["check", str(path), "--robot", "panda", "--scene", str(tmp_path / "bar.yaml"), "--json"]) == 0
    (kept,) = json.loads(capsys.readouterr().out)["constraints"]
    assert kept["proven"]
    tipped = upright.path.copy()
    tipped[1, 5] += 0.3
    np.savetxt(path, tipped, delimiter=",")
    code = run(
        ["check", str(path), "--robot", "panda", "--scene", "empty", "--constraint", "turn:3", "--constraint", DOWN]
    )
    assert code == 4
    assert "is broken by" in " ".join(capsys.readouterr().out.split())


def test_a_session_keeps_it(upright):
    session = planner.Session("panda", "empty", constraint=DOWN, nodes=40)
    plan = session.plan("home", "xyz:-0.4,-0.4,0.5", timing=None)
    assert plan.solved
    assert tilt(plan.robot, dense(plan.path)) <= 5.0 + 1e-6
    session.add(planner.Obstacle("ball", planner.Sphere(0.05), planner.pose([0.0, -0.6, 0.5])))
    plan = session.replan()
    assert not plan.solved or tilt(plan.robot, dense(plan.path)) <= 5.0 + 1e-6
    with pytest.raises(PlannerError, match="must have an orientation here"):
        planner.Session("panda", "empty", constraint="turn:0.1")
