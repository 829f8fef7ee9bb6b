"""The informed set: its states and its box, against many states asked one by one."""

from __future__ import annotations

import numpy as np
import pytest

from planner.planning.plan import plan
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest
from planner.roadmap.informed_set import InformedSet
from planner.roadmap.ompl_planners import TreePlanners
from tests.worlds import load


@pytest.mark.parametrize("name", ["planar_2r", "kinova"])
def test_it_holds_what_a_path_of_that_length_may_pass(name: str) -> None:
    robot, rng = load(name), np.random.default_rng(0)
    starts, goals = (robot.home + rng.uniform(-0.1, 0.1, (count, robot.dof)) for count in (2, 1))
    apart = np.linalg.norm(robot.difference(starts, goals), axis=1)
    longest = 1.2 * apart.max()
    within = InformedSet(robot, starts, goals, longest)
    # points of the ellipsoid's surface: as far along random directions from its middle as it reaches
    middle, half = 0.5 * (starts[0] + goals[0]), np.linspace(0.0, longest, 4001)
    ends = []
    for direction in [*np.eye(robot.dof), *rng.normal(size=(50, robot.dof))]:
        ray = middle + half[:, None] * direction / np.linalg.norm(direction)
        far = np.linalg.norm(ray - starts[0], axis=1) + np.linalg.norm(ray - goals[0], axis=1)
        inside = far <= longest
        ends.append(ray[inside][-1])
        assert within.holds(ends[-1].tolist())
    lower, upper = within.space.lower, within.space.upper
    turns = robot.continuous
    assert (((np.array(ends) >= lower - 1e-9) & (np.array(ends) <= upper + 1e-9)) | turns).all()
    around = 0.5 * longest + 0.1
    box = middle + rng.uniform(-around, around, (2000, robot.dof))
    expected = np.linalg.norm(box[:, None] - starts, axis=2).min(axis=1) + np.linalg.norm(box - goals[0], axis=1)
    assert [within.holds(q) for q in box.tolist()] == (expected <= longest).tolist()
    held = box[expected <= longest]
    assert (((held >= lower) & (held <= upper)) | turns).all()


def test_a_path_of_any_length_may_pass_everywhere() -> None:
    robot = load("panda")
    within = InformedSet(robot, robot.home[None], robot.home[None] + 0.1, np.inf)
    assert within.holds(robot.upper.tolist())
    np.testing.assert_array_equal(within.space.upper, robot.upper)


def test_the_box_touches_the_set_on_every_side() -> None:
    robot = load("planar_2r")
    start, goal = np.array([-0.5, 0.2]), np.array([0.4, -0.3])
    space = InformedSet(robot, start[None], goal[None], 1.3).space
    turn = np.linspace(0.0, 2.0 * np.pi, 20001)
    axis = (goal - start) / np.linalg.norm(goal - start)
    short = np.sqrt(1.3**2 - ((goal - start) ** 2).sum()) / 2
    ring = 0.65 * np.cos(turn)[:, None] * axis + short * np.sin(turn)[:, None] * np.array([-axis[1], axis[0]])
    ring += 0.5 * (start + goal)
    np.testing.assert_allclose([space.lower, space.upper], [ring.min(axis=0), ring.max(axis=0)], atol=1e-6)


@pytest.mark.parametrize("apart", [5e-324, 1e-310, 1e-160, 1e-30, 1e-17, 1e-12])
def test_ends_that_are_all_but_the_same_leave_a_box_to_sample(apart: float) -> None:
    robot = load("planar_2r")
    for start in (np.array([0.0, 1.0]), robot.upper):
        goal = start - [apart, 0.0]
        space = InformedSet(robot, start[None], goal[None], float(np.linalg.norm(goal - start))).space
        with TreePlanners(space, lambda first, delta: True, np.random.default_rng(0)) as planners:
            assert planners.rrt_connect(start[None], goal[None], 0.1, 10) is not None


def test_a_plan_between_ends_that_are_all_but_the_same() -> None:
    found = plan(PlanRequest.from_options(robot="planar_2r", scene="empty", start="q:0,1", goal="q:1e-310,1", nodes=20))
    assert found.outcome is Outcome.SOLVED
