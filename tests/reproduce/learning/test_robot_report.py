"""What is said of learning on a robot."""

from __future__ import annotations

from dataclasses import replace

from planner.reproduce.learning import robot as learning_robot
from planner.reproduce.learning.robot import PRIORS, TASKS, RobotSettings, robot_verdicts
from planner.reproduce.report import Report
from tests.reproduce.learning.small import ROBOT


def test_robot_verdicts_say_no_where_regret_stays(report: Report) -> None:
    settings = replace(ROBOT, executions=3)
    [case] = [learning_robot.make_case(query_of(settings), settings.nodes, 0, 0)]
    assert case is not None
    good = learning_robot.campaign(case, "optimistic", "one start", 25, 0)
    stuck = replace(good, steps=(*good.steps[:-1], replace(good.steps[-1], regret=0.5)), costly=99)
    others = [replace(good, prior=prior, task=task) for prior in PRIORS for task in TASKS]
    assert robot_verdicts([stuck, *others[1:]])[0].confirmed == 0
    assert not robot_verdicts([stuck, *others[1:]])[3].holds
    assert good.last_regret <= learning_robot.LOSS
    assert robot_verdicts([]) == ()


def query_of(settings: RobotSettings):
    from planner.problem.request import RoadmapRequest
    from planner.setup.open import make_query

    request = RoadmapRequest(settings.robot, settings.scene, start=settings.start, goal=settings.goal)
    return make_query(request, near_start=False)
