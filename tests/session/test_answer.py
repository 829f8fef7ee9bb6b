"""From a query to its answer: the first grows a roadmap, later ones link their ends, old guests leave."""

import numpy as np
import pytest

from planner import gabf
from planner.problem.request import PlanRequest
from planner.problem.targets import Joints
from planner.query.query import Query, resolve_query
from planner.roadmap.grow import GrowthSettings
from planner.session.live_roadmap import LiveRoadmap
from planner.session.solve import PlanningSettings, solve_query
from tests.worlds import POST_GOAL, POST_START, make_post, post_roadmap

PLANNING = PlanningSettings(
    PlanRequest.from_options(nodes=60, refinement_rounds=0), gabf.SingularityFree(), GrowthSettings()
)


def bare() -> LiveRoadmap:
    return LiveRoadmap.from_checker(make_post())


def query(live: LiveRoadmap, start: np.ndarray = POST_START, goal: np.ndarray = POST_GOAL) -> Query:
    return resolve_query(live.checker, Joints(tuple(start)), [Joints(tuple(goal))], 1, (1e-6, 1e-4))


def test_the_first_query_grows_the_roadmap_that_a_plan_would() -> None:
    live = bare()
    moment, answer = solve_query(live, query(live), PLANNING)
    assert moment.roadmap.sha256 == post_roadmap().sha256
    assert answer.solved
    assert answer.goal == "q:1.0,-0.8"
    assert answer.max_error_vs_oracle is not None
    assert answer.max_error_vs_oracle <= 1e-9
    assert answer.cost is not None
    assert answer.cost.total == pytest.approx(float(answer.cost_to_go.x[answer.path_nodes[0]]), rel=1e-12)


def test_later_queries_add_little_and_heal_the_field_of_before() -> None:
    live = bare()
    first, _ = solve_query(live, query(live), PLANNING)
    n = len(first.roadmap.nodes)
    second, answer = solve_query(first, query(live, POST_START + 0.05), PLANNING)
    guests = len(second.roadmap.nodes) - n  # the new start, and the straight motion from it to the goal
    assert 1 <= guests < 12
    assert answer.rounds > 0
    assert answer.nodes_grown == 0
    np.testing.assert_array_equal(answer.path[0], POST_START + 0.05)
    again, same = solve_query(second, query(live, POST_START + 0.05), PLANNING)
    assert same.edges.proven == 0
    np.testing.assert_array_equal(same.path, answer.path)
    assert len(again.roadmap.nodes) == n + guests
