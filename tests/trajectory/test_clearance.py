"""The smallest clearance of path and motion: against dense sampling by coal, with its pair and its place."""

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.recheck import Clearance
from planner.planning.plan import plan
from planner.planning.record import ClearanceRecord
from planner.problem.request import PlanRequest, TimingRequest
from planner.robot.scene import Scene
from planner.trajectory.measure import (
    dense_path,
    nearest_in_motion,
    nearest_on_path,
    nearest_pair,
)
from planner.trajectory.timing import time_path
from tests.worlds import load


@pytest.mark.parametrize(("robot", "scene"), [("planar_2r", "cage"), ("panda", "shelf")])
def test_the_smallest_the_pair_and_the_place(robot: str, scene: str) -> None:
    found = plan(
        request=PlanRequest.from_options(robot=robot, scene=scene, path_only=True, extra_clearance=0.0),
        timing=TimingRequest(),
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
    least = Clearance(judge)(dense_path(found.path, 1e-3)).min()
    assert least - 1e-5 <= path.min <= least + max(1e-5, 0.11 * path.min)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(found.path, axis=0), axis=1))])
    q = [np.interp(path.at * lengths[-1], lengths, column) for column in found.path.T]
    assert Clearance(judge)(np.array(q))[0] == pytest.approx(path.min, abs=2e-5)


def test_where_nothing_is_there_is_nothing_to_come_near_to() -> None:
    whole = make_checker(load("planar_2r"), Scene.load("empty"))
    checker = type(whole)(whole.world.only(np.zeros(len(whole.world.pair_reach), dtype=bool)))
    q = np.array([[0.0, 0.5], [0.5, 1.0]])
    assert nearest_on_path(q, checker) is None
    assert nearest_in_motion(time_path(q, checker), checker) is None
    rows = ClearanceRecord(path=None, motion=None, kept=0.0).rows(0.005)
    assert rows == [("clearance", "no pair is checked")]
