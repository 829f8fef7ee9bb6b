"""The search for a first path: proven motions from a start to a goal, or None within its counts."""

from typing import Any

import numpy as np
import pytest

from planner.base.progress import Progress
from planner.collision.edge_prover import EdgeProver, MotionCheck, Verdict
from planner.collision.recheck import sample_segment
from planner.problem.request import PlanRequest
from planner.query.query import make_query
from planner.roadmap.edges import MotionChecker
from planner.roadmap.first_path import FirstPathSearch, InformedSet, JoinSettings
from planner.roadmap.ompl_planners import JointSpace, TreePlanners
from tests.worlds import POST_GOAL, POST_START, load, make_post, post_roadmap

SETTINGS = JoinSettings(range=0.4, motions=4000, shortcuts=20)


def search(prover: EdgeProver, progress: Progress | None = None) -> FirstPathSearch:
    return FirstPathSearch(MotionChecker(prover), SETTINGS, np.random.default_rng(0), progress or Progress())


def test_the_path_is_proven_subdivided_and_joins_its_ends() -> None:
    checker = make_post()
    found = search(EdgeProver(checker)).join(POST_START[None], POST_GOAL[None])
    assert found is not None
    np.testing.assert_array_equal(found[[0, -1]], [POST_START, POST_GOAL])
    delta = np.diff(found, axis=0)
    assert np.linalg.norm(delta, axis=1).max() <= SETTINGS.range * (1 + 1e-9)
    assert (EdgeProver(checker).prove(found[:-1], delta).verdict == Verdict.FREE).all()
    assert all(sample_segment(checker, q, d, 1e-3) is None for q, d in zip(found, delta, strict=False))


@pytest.mark.parametrize(("scene", "seed"), [("shelf", 2), ("table", 0), ("table", 1), ("window", 0)])
def test_joints_that_turn_freely(scene: str, seed: int) -> None:
    """They were shortened to motions the other way round, through the table, and ends lost their last bit."""
    query = make_query(PlanRequest.from_options(robot="kinova", scene=scene).what)
    prover, robot = EdgeProver(query.checker), query.robot
    searched = FirstPathSearch(MotionChecker(prover), JoinSettings(0.4, 56_000, 16), np.random.default_rng(seed))
    found = searched.join(query.starts, query.goals)
    assert found is not None
    np.testing.assert_array_equal(found[[0, -1]], [query.starts[0], query.goals[0]])
    delta = robot.difference(found[:-1], found[1:])
    assert (prover.prove(found[:-1], delta).verdict == Verdict.FREE).all()
    assert all(sample_segment(query.checker, q, d, 5e-3) is None for q, d in zip(found, delta, strict=False))


def test_a_narrow_passage_takes_few_motions() -> None:
    """Through the window, where OMPL's RRTConnect checks several times as many."""
    query = make_query(PlanRequest.from_options(robot="iiwa14", scene="window").what)
    motions, settings = MotionChecker(EdgeProver(query.checker)), JoinSettings(range=0.8, motions=20_000, shortcuts=0)
    few = many = 0
    for seed in range(5):
        searched = FirstPathSearch(motions, settings, np.random.default_rng(seed))
        assert searched.join(query.starts, query.goals) is not None
        few += searched.checked
        look, space = motions.make_state_check(0.05), JointSpace.from_robot(query.robot)
        with TreePlanners(space, look, np.random.default_rng(seed)) as planners:
            planners.rrt_connect(query.starts, query.goals, settings.range, settings.motions)
        many += planners.checked
    assert 2 * few < many


class Nothing(EdgeProver):
    """Proves no motion at all."""

    def prove(self, *motions: Any, **more: Any):
        proofs = super().prove(*motions, **more)
        proofs.verdict[:] = Verdict.UNDECIDED
        return proofs

    def each_free(self, *_: Any, **__: Any) -> MotionCheck:
        return lambda first, delta: False


def test_what_cannot_be_proven_is_not_returned_and_the_search_ends() -> None:
    looking = search(Nothing(make_post()))
    assert looking.join(POST_START[None], POST_GOAL[None]) is None
    assert looking.checked >= SETTINGS.motions


def test_near_a_gap_the_path_is_proven_and_begins_and_ends_at_nodes() -> None:
    checker, nodes = make_post(), post_roadmap().nodes
    left, right = nodes[nodes[:, 0] < -0.2], nodes[nodes[:, 0] > 0.2]
    apart = np.linalg.norm(left[:, None] - right[None], axis=2)
    i, k = np.unravel_index(np.argmin(apart), apart.shape)
    gap = np.array([left[i], right[k]])
    found = search(EdgeProver(checker)).join_near(left, right, gap)
    assert found is not None
    assert (left == found[0]).all(axis=1).any()
    assert (right == found[-1]).all(axis=1).any()
    delta = np.diff(found, axis=0)
    assert all(sample_segment(checker, q, d, 1e-3) is None for q, d in zip(found, delta, strict=False))
    assert (found >= gap.min(axis=0) - 1.0).all()  # the largest box
    assert (found <= gap.max(axis=0) + 1.0).all()


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
        assert within.contains(ends[-1].tolist())
    lower, upper = within.space.lower, within.space.upper
    turns = robot.continuous
    assert (((np.array(ends) >= lower - 1e-9) & (np.array(ends) <= upper + 1e-9)) | turns).all()
    around = 0.5 * longest + 0.1
    box = middle + rng.uniform(-around, around, (2000, robot.dof))
    expected = np.linalg.norm(box[:, None] - starts, axis=2).min(axis=1) + np.linalg.norm(box - goals[0], axis=1)
    assert [within.contains(q) for q in box.tolist()] == (expected <= longest).tolist()
    held = box[expected <= longest]
    assert (((held >= lower) & (held <= upper)) | turns).all()


@pytest.mark.parametrize("apart", [5e-324, 1e-310, 1e-160, 1e-30, 1e-17, 1e-12])
def test_ends_that_are_all_but_the_same_leave_a_box_to_sample(apart: float) -> None:
    robot = load("planar_2r")
    for start in (np.array([0.0, 1.0]), robot.upper):
        goal = start - [apart, 0.0]
        space = InformedSet(robot, start[None], goal[None], float(np.linalg.norm(goal - start))).space
        with TreePlanners(space, lambda first, delta: True, np.random.default_rng(0)) as planners:
            assert planners.rrt_connect(start[None], goal[None], 0.1, 10) is not None
