"""A session's tasks: from where the arm is, holding what it holds, in the world as it is by then."""

from typing import Any

import numpy as np
import pytest

import planner
from planner.base.errors import SceneError
from planner.kinematics.forward import tool_pose
from planner.problem.request import TimingRequest
from planner.session.session import Session
from planner.tasks.plan import task
from planner.tasks.result import _scene_in_motion
from planner.tasks.task import Move, Pick, Place, TaskError
from tests.tasks.cases import BOARD, GRASPS, MUG, ON_BOARD, SCENE, SMALL

FEW: dict[str, Any] = {"nodes": 100, "ik_solutions": 2}


@pytest.fixture(scope="module")
def session() -> Session:
    return Session("panda", SCENE)


@pytest.fixture(scope="module")
def carrying(session: Session):
    """The session after the first steps: the arm half way, the mug in its hand."""
    first = session.task(SMALL, **FEW, timing=None)
    assert first.solved, first.message
    before, grasp, way = session.checker, first.segments[1].path[-1], first.segments[3].path
    session.attach("mug", first.robot.tool, at=grasp)
    yield session, 0.5 * (way[0] + way[1]), grasp
    session.world.restore(before)


def test_it_plans_what_a_task_plans(session: Session) -> None:
    found, alone = session.task(SMALL.steps, **FEW, timing=None), task(SMALL, **FEW, timing=None)
    assert found.cost == alone.cost
    np.testing.assert_array_equal(found.path, alone.path)


def test_the_same_steps_are_answered_on_what_is_known(session: Session) -> None:
    steps = SMALL.steps
    first = session.task(steps, start="home", **FEW, timing=None)
    assert first.roadmap is not None
    again = session.task(steps, start=first.roadmap.nodes[30], beta=0.3, **FEW, timing=None)
    assert again.candidates is first.candidates
    np.testing.assert_allclose(again.path[0], first.roadmap.nodes[30])
    session.move("post", position=[0.75, 0.0, 0.225])
    moved = session.task(steps, start="home", **FEW, timing=None)
    assert moved.candidates is not first.candidates
    assert moved.solved
    session.move("post", position=[0.62, 0.0, 0.225])


def test_what_is_held_is_put_down_from_where_the_arm_is(carrying) -> None:
    session, q, grasp = carrying
    found = session.task((ON_BOARD, Move("home")), start=q, timing=TimingRequest(), **FEW)
    assert found.solved, found.message
    assert [(s.step, s.part, s.carried) for s in found.segments] == [
        (1, "transit", "mug"),
        (1, "approach", "mug"),
        (1, "retreat", None),
        (2, "transit", None),
    ]
    assert [event.kind for event in found.events] == ["detach", "gripper"]
    np.testing.assert_allclose(found.path[0], q)
    robot = found.robot
    hold = np.linalg.inv(tool_pose(robot, grasp).homogeneous) @ MUG.placement
    put = tool_pose(robot, found.segments[1].path[-1]).homogeneous @ hold
    np.testing.assert_allclose(put[2], [0, 0, 1, 0.22 + 0.12 + 1e-3], atol=1e-4)
    assert found.trajectory is not None
    assert found.trajectory.proven
    assert planner.check(found, step=1e-4).ok
    assert "mug" in found.page()
    (drawn,) = _scene_in_motion(found, found.trajectory).moving
    for t in np.linspace(0.0, found.segments[0].trajectory.duration, 9):
        at = tool_pose(robot, found.trajectory.at(t)[0]).homogeneous @ hold
        np.testing.assert_allclose(drawn.motion.at(t)[0], at, atol=2e-3)


def test_it_may_be_taken_again_and_moved_while_held(carrying) -> None:
    session, q, _ = carrying
    found = session.task((Move("home"), ON_BOARD, Pick("mug", GRASPS), Move("home")), start=q, **FEW, timing=None)
    assert found.solved, found.message
    assert [event.kind for event in found.events if event.kind != "gripper"] == ["detach", "attach"]
    assert [s.carried for s in found.segments][:2] == ["mug", "mug"]
    assert found.segments[-1].carried == "mug"
    assert planner.check(found).ok


def test_a_floor_is_refused_and_nothing_is_held_at_first() -> None:
    with pytest.raises(TaskError, match="nothing is held: pick it first"):
        Session("panda", SCENE).task((Place("mug", pose=(BOARD.placement,)),), **FEW, timing=None)
    with pytest.raises(SceneError, match="min_manipulability must be 0 for tasks"):
        Session("panda", SCENE, min_manipulability=0.01).task(SMALL, timing=None)
