"""Several objects one after the other: each placed where the others are not, in a world that the first has changed."""

from functools import cache

import numpy as np

import planner
from planner.kinematics.forward import tool_pose
from planner.problem.request import TimingRequest
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle
from planner.tasks.plan import TaskPlanner
from planner.tasks.result import TaskPlan
from planner.tasks.sampling import tool_at
from planner.tasks.task import Grasp, Move, Pick, Place, Task
from tests.tasks.cases import TABLE
from tests.worlds import load

CUBE = Box((0.05, 0.05, 0.05))
FIRST = Obstacle("first", CUBE, pose((0.45, -0.25, 0.025)))
SECOND = Obstacle("second", CUBE, pose((0.55, -0.15, 0.025)))
FROM_ABOVE = tuple(
    Grasp.from_matrix(tool_at(np.zeros(3), np.array([0.0, 0.0, -1.0]), np.array(closing)), 0.05)
    for closing in ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
)
SPOT = (0.4, 0.1), (0.6, 0.35)  # two cubes fit in side by side, in some places


def steps_of(name: str) -> tuple[Pick, Place]:
    return Pick(name, FROM_ABOVE), Place(name, "table", SPOT, samples=4)


@cache
def both() -> TaskPlan:
    scene = Scene("two cubes", (TABLE, FIRST, SECOND))
    task = Task("panda", scene, (*steps_of("first"), *steps_of("second"), Move("home")))
    return TaskPlanner.from_task(task, nodes=120, ik_solutions=1).plan(timing=TimingRequest())


def test_two_objects_are_placed_side_by_side() -> None:
    found = both()
    assert found.solved, found.message
    assert [segment.carried for segment in found.segments if segment.carried] == ["first"] * 3 + ["second"] * 3
    assert [event.object for event in found.events if event.kind == "attach"] == ["first", "second"]
    assert planner.check(found).ok
    robot, put = load("panda"), {}
    for name, cube in (("first", FIRST), ("second", SECOND)):
        ends = [s.path[-1] for s in found.segments if s.doing.endswith(name) and s.part == "approach"]
        pick, place = (tool_pose(robot, q).homogeneous for q in ends)
        put[name] = place @ np.linalg.inv(pick) @ cube.placement
    apart = np.linalg.norm(put["first"][:2, 3] - put["second"][:2, 3])
    assert apart >= 0.05


def test_what_was_placed_can_be_taken_again() -> None:
    scene = Scene("one cube", (TABLE, FIRST))
    back = Place("first", "table", ((0.35, -0.35), (0.55, -0.15)), samples=3)
    task = Task("panda", scene, (*steps_of("first"), Pick("first", FROM_ABOVE), back))
    found = TaskPlanner.from_task(task, nodes=120, ik_solutions=1).plan(timing=TimingRequest())
    assert found.solved, found.message
    assert [event.kind for event in found.events if event.kind != "gripper"] == ["attach", "detach"] * 2
    assert planner.check(found).ok
