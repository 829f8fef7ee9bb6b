"""Shortcuts in time: quicker, proven, and never dearer than allowed, by a measure that knows nothing of chords."""

import itertools

import numpy as np
import pytest

from planner.collision import make_checker, second_checker
from planner.collision.recheck import sample_contacts
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.planning.solve import make_timing_cost
from planner.problem.request import PlanRequest, TimingRequest
from planner.robot.poses import pose
from planner.robot.shapes import Box
from planner.trajectory.timing import time_curve, time_path
from planner.trajectory.trajectory import Trajectory
from tests.worlds import load, scene_of

ARM = load("planar_2r")
# the arm turns past it: q1 from -0.9 to 0.9, folded in between
CHECKER = make_checker(ARM, scene_of((Box((0.1, 0.1, 0.1)), pose([1.6, 0.0, 0.0]))))
PATH = np.array([[-0.9, 0.4], [-0.35, 1.5], [0.35, 1.4], [0.9, 0.3]])


def length(motion: Trajectory) -> float:
    q = motion.at(np.linspace(0.0, motion.duration, 20_001))
    return float(np.linalg.norm(np.diff(q, axis=0), axis=1).sum())


def test_they_are_quicker_and_no_longer_than_the_path() -> None:
    (rounded, _), (found, _) = (time_curve(PATH, CHECKER, None, law, 0.0) for law in ("blended", "shortcuts"))
    assert found.proof["shortcuts"] > 0
    assert found.proven
    assert found.duration < 0.97 * rounded.duration
    assert length(found) <= np.linalg.norm(np.diff(PATH, axis=0), axis=1).sum()
    assert sample_contacts(second_checker(CHECKER), found.coefficients, 1e-3) is None


def test_the_floor_holds_on_them() -> None:
    floor = 0.99 * float(manipulability(ARM, PATH).min())
    free, kept = (time_path(PATH, CHECKER, floor=level, time_law="shortcuts") for level in (0.0, floor))
    assert kept.proven
    assert manipulability(ARM, kept.at(np.linspace(0.0, kept.duration, 2001))).min() >= floor
    assert kept.duration >= free.duration


@pytest.mark.parametrize("extra", [0.0, 0.2])
def test_of_a_plan_they_keep_its_objective(solved: Plan, extra: float) -> None:
    cost = make_timing_cost(solved)
    motion = time_path(solved.path, solved.checker, time_law="shortcuts", cost=cost, extra_cost=extra)
    slower, _ = time_curve(solved.path, solved.checker, None, "blended", 0.0)
    assert motion.proven
    assert motion.duration <= slower.duration
    assert sample_contacts(second_checker(solved.checker), motion.coefficients, 1e-3) is None
    assert _sampled(cost, motion.at(np.linspace(0.0, motion.duration, 400))) <= (1.0 + extra) * 1.01 * _sampled(
        cost, np.concatenate([np.linspace(a, b, 60) for a, b in zip(solved.path[:-1], solved.path[1:], strict=True)])
    )


def test_the_tool_goes_no_farther_where_its_path_is_the_cost() -> None:
    """What an edge costs at least is no measure of its parts, of which many move the tool by less."""
    start, goal = [0.1, 2.4, -1.9, 2.4, -1.0, -0.4], [1.8, -0.5, 0.3, -2.6, 1.4, 0.2]
    request = PlanRequest.from_options(
        robot="ur5", scene="empty", start=start, goal=goal, beta=1.0, metric="workspace", nodes=100, refinement_rounds=1
    )
    found = plan(request=request, timing=TimingRequest())
    motion = found.trajectory
    assert motion is not None
    assert motion.proof["shortcuts"] > 0
    way = np.concatenate([np.linspace(a, b, 200) for a, b in itertools.pairwise(found.path)])
    of_motion, of_path = (
        _length(tool_positions(found.robot, q)) for q in (motion.at(np.linspace(0.0, motion.duration, 20_001)), way)
    )
    assert of_motion <= 1.01 * of_path


def _length(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _sampled(cost, q: np.ndarray) -> float:
    """The objective along chords that are thinned to be no shorter than 0.06 rad."""
    kept = [0]
    for k in range(1, len(q)):
        if np.linalg.norm(q[k] - q[kept[-1]]) > 0.06 or k == len(q) - 1:
            kept.append(k)
    return float(cost(q[kept[:-1]], q[kept[1:]]).sum())
