"""The smallest clearance of path and motion: against dense sampling by coal, with its pair and its place."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.checker import CollisionChecker, is_free
from planner.collision.looks import Clearance
from planner.planning.plan import plan
from planner.planning.record import ClearanceRecord
from planner.problem.request import PlanRequest, TimingRequest
from planner.robot.scene import Scene
from planner.trajectory.measure import (
    CLOSE,
    TOO_CLOSE,
    Nearest,
    nearest_in_motion,
    nearest_on_path,
    nearest_pair,
    slack,
    smallest_clearance,
)
from planner.trajectory.timing import time_path
from tests.coal_judge import CoalWorld
from tests.worlds import checker_of, load, random_q


@pytest.mark.parametrize(("robot", "scene"), [("planar_2r", "cage"), ("panda", "shelf")])
def test_the_smallest_the_pair_and_the_place(robot: str, scene: str) -> None:
    found = plan(
        request=PlanRequest.from_options(robot=robot, scene=scene, path_only=True, room=0.0), timing=TimingRequest()
    )
    judge = make_checker(found.robot, found.scene, "coal")
    motion = found.trajectory
    assert motion is not None
    t = np.linspace(0.0, motion.duration, 4000)
    distance = Clearance(judge)(motion.at(t))
    told = nearest_in_motion(motion, found.checker)
    assert told is not None
    assert distance.min() - 1e-5 <= told.min <= distance.min() + max(1e-5, 0.11 * told.min)
    there = motion.at(told.at)
    assert Clearance(judge)(there)[0] == pytest.approx(told.min, abs=2e-5)
    pair = nearest_pair(judge, there[0])
    assert pair is not None
    assert told.pair == (pair.first, pair.second)
    path = nearest_on_path(found.path, found.checker)
    assert path is not None
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(found.path, axis=0), axis=1))])
    q = [np.interp(path.at * lengths[-1], lengths, column) for column in found.path.T]
    assert Clearance(judge)(np.array(q))[0] == pytest.approx(path.min, abs=2e-5)


def free_path(checker: CollisionChecker, rows: int = 4, seed: int = 0, step: float = 0.15) -> np.ndarray:
    """A short random walk of free configurations; what lies between them may touch."""
    robot, rng = checker.robot, np.random.default_rng(seed)
    path = [next(q for q in random_q(robot, 200, seed) if is_free(checker, q))]
    while len(path) < rows:
        q = np.clip(path[-1] + rng.normal(size=robot.dof) * step, robot.lower, robot.upper)
        if is_free(checker, q):
            path.append(q)
    return np.array(path)


@pytest.mark.parametrize(("robot", "scene"), [("iiwa14", "paper"), ("ur5", "table"), ("planar_2r", "window")])
def test_smallest_clearance_against_coal(robot: str, scene: str) -> None:
    checker = checker_of(robot, scene)
    coal = CoalWorld(checker.world)
    moved = np.flatnonzero(checker.world.pair_reach.any(axis=1))
    for seed in range(2):
        path = free_path(checker, 3, seed)
        found = smallest_clearance(checker, path)
        assert found is not None
        value, segment, share, q = found
        a, b = path[segment : segment + 2]
        np.testing.assert_allclose(q, a + share * (b - a), atol=1e-12)
        here = coal.distances(q, moved)
        assert value == pytest.approx(max(0.0, here.min()), abs=2e-4)
        dense = np.concatenate([p + np.linspace(0, 1, 25)[:, None] * (r - p) for p, r in itertools.pairwise(path)])
        true = min(max(0.0, coal.distances(each, moved).min()) for each in dense)
        assert value <= true + slack(true) + 2e-4
        if value > 1e-3:
            assert nearest_pair(checker, q) == checker.world.contact(int(moved[here.argmin()]))


def test_where_nothing_is_there_is_nothing_to_come_near_to() -> None:
    whole = make_checker(load("planar_2r"), Scene.load("empty"))
    checker = type(whole)(whole.world.only(np.zeros(len(whole.world.pair_reach), dtype=bool)))
    q = np.array([[0.0, 0.5], [0.5, 1.0]])
    assert nearest_on_path(q, checker) is None
    assert nearest_in_motion(time_path(q, checker), checker) is None
    rows = ClearanceRecord(path=None, motion=None, kept=0.0).rows(0.005)
    assert rows == [("clearance", "there is nothing to come near to")]


def test_what_is_too_close_is_said_with_the_remedy() -> None:
    near, far = Nearest(CLOSE - 1e-4, ("hand", "shelf"), 0.5), Nearest(CLOSE + 1e-4, ("hand", "shelf"), 1.25)
    rows = dict(ClearanceRecord(path=far, motion=near, kept=0.0).rows(0.005))
    assert rows["clearance"] == (
        "5.1 mm ('hand' and 'shelf') at 125 % of the path; 4.9 mm ('hand' and 'shelf') at 0.500 s of the motion"
    )
    assert "--margin" in rows[TOO_CLOSE]
    assert TOO_CLOSE not in dict(ClearanceRecord(path=far, motion=None, kept=0.005).rows(0.005))
    halved = dict(ClearanceRecord(path=near, motion=None, kept=0.0025).rows(0.005))
    assert "keep 2.5 of 5 mm" in halved["clearance"]
