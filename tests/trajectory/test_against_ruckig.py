"""Ruckig, which is time-optimal from state to state, as an independent judge: nothing of ours may be quicker.

It is no dependency: these tests are skipped where it is not installed. Each segment is asked for on this machine, never
as waypoints, for which Ruckig calls a server.
"""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from planner.collision import make_checker
from planner.robot.poses import pose
from planner.robot.shapes import Box
from planner.trajectory.limits import MotionLimits
from planner.trajectory.stopping import stop_at
from planner.trajectory.timing import time_path
from tests.worlds import load, scene_of

ruckig = pytest.importorskip("ruckig")

ARM = load("planar_2r")
FREE = make_checker(ARM, scene_of((Box((0.1, 0.1, 0.1)), pose([5.0, 0.0, 0.0]))))
PATH = np.array([[-1.0, 0.5], [0.0, 1.0], [1.0, 0.5], [1.2, -0.5]])
LIMITS = MotionLimits.from_robot(ARM)
NO_JERK = 1e6


def fastest_phases(
    start: tuple[np.ndarray, np.ndarray], end: tuple[np.ndarray, np.ndarray], limits: MotionLimits, jerk: np.ndarray
) -> float:
    """Seconds from a position and velocity to another, accelerations free or 0, every joint by itself."""
    asked = ruckig.InputParameter(len(jerk))
    asked.current_position, asked.current_velocity = (row.tolist() for row in start)
    asked.target_position, asked.target_velocity = (row.tolist() for row in end)
    asked.max_velocity, asked.max_acceleration = limits.velocity.tolist(), limits.acceleration.tolist()
    asked.max_jerk = jerk.tolist()
    found = ruckig.Trajectory(len(jerk))
    assert ruckig.Ruckig(len(jerk)).calculate(asked, found) in (ruckig.Result.Working, ruckig.Result.Finished)
    return found.duration


@pytest.mark.parametrize("jerk", [50.0, 500.0, 5000.0])
def test_stopping_at_corners_takes_little_longer(jerk: float) -> None:
    """The mean over a window limits the jerk to twice the acceleration by the window; the optimum is less by a half."""
    limits = replace(LIMITS, jerk=np.full(2, jerk))
    ours = time_path(PATH, FREE, limits, time_law="stop-at-corners").duration
    still = np.zeros(2)
    best = sum(fastest_phases((a, still), (b, still), limits, limits.jerk) for a, b in itertools.pairwise(PATH))
    window = float((2 * limits.acceleration / limits.jerk).max())
    assert best <= ours <= 1.002 * best + 3 * window


def test_no_part_of_a_motion_is_quicker_than_the_optimum() -> None:
    motion = time_path(PATH, FREE, LIMITS)
    for early, late in np.sort(np.random.default_rng(2).uniform(0.0, motion.duration, size=(40, 2)), axis=1):
        start, end = ((motion.at(t)[0], motion.at(t, 1)[0]) for t in (early, late))
        assert fastest_phases(start, end, LIMITS, np.full(2, NO_JERK)) <= (late - early) * (1 + 1e-6) + 1e-4


def test_a_stop_is_no_quicker_than_braking_each_joint_alone() -> None:
    motion = time_path(PATH, FREE, LIMITS)
    for t in np.random.default_rng(3).uniform(0.0, motion.duration, size=20).tolist():
        stop = stop_at(motion, t).trajectory
        start, end = ((stop.at(s)[0], stop.at(s, 1)[0]) for s in (0.0, stop.duration))
        best = fastest_phases(start, end, LIMITS, np.full(2, NO_JERK))
        assert best <= stop.duration + 1e-4
