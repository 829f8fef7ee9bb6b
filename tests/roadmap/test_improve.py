"""Refined paths and searches: against the exact optimum of a planar arm, cheaper, proven, above floors, repeatable."""

import numpy as np

from planner.cost.motion_cost import MotionCost
from planner.planning.plan import plan
from planner.problem.request import Objective, PlanRequest
from planner.roadmap.improve import improve
from planner.roadmap.refine import TOLERANCE
from planner.robot.poses import pose
from planner.robot.scene import Obstacle, Scene
from planner.robot.shapes import Box
from planner.trajectory.measure import count_corners, joint_path_length
from tests.worlds import small_plan

BAR = Scene("bar", (Obstacle("box", Box((0.1, 0.04, 0.2)), pose([0.75, 0, 0])),))
ASKED = PlanRequest.from_options(
    robot="planar_2r", scene=BAR, start="q:-1.0,0.8", goal="q:1.3,-0.8", nodes=60, beta=1.0, extra_clearance=0.0
)
SHORTEST = 3.646  # rad: the hull of ends and contact states, bisected in 1001 columns; the other side takes 3.6626


def test_the_effort_converges_to_the_shortest_path() -> None:
    found = [plan(request=ASKED.with_options(refinement_rounds=effort), timing=None) for effort in (0, 30)]
    length = [joint_path_length(each.path) for each in found]
    assert SHORTEST - 1e-3 < length[1] < 1.005 * SHORTEST
    assert length[1] < length[0]
    assert count_corners(found[1].path) <= 6
    costs = [cost for _, cost in found[1].curve]
    assert costs[:-1] == sorted(costs[:-1], reverse=True)
    assert costs[-1] <= (1.0 + TOLERANCE) * costs[-2]  # fewer corners may cost a bit


def test_improvement_keeps_the_roadmap_and_repeats() -> None:
    made = small_plan()
    cost = MotionCost(made.robot, made.roadmap.scale, Objective())
    one, two = (improve(made.roadmap, made.checker, cost, made.path, 2, seed=4) for _ in range(2))
    assert one.roadmap.sha256 == two.roadmap.sha256
    assert one.curve == two.curve
    n = len(made.roadmap.nodes)
    np.testing.assert_array_equal(one.roadmap.nodes[:n], made.roadmap.nodes)
    theirs, mine = ({tuple(edge) for edge in each.edges.tolist()} for each in (one.roadmap, made.roadmap))
    assert mine <= theirs
