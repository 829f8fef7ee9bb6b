"""Rows on an exact grid: their times, the limits by rational numbers, rest at both ends, proofs; rows between knots."""

import json
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from planner.base.errors import PlannerError
from planner.collision import make_checker
from planner.problem.options import TimeLaw
from planner.problem.request import LimitsRequest
from planner.robot.poses import pose
from planner.robot.shapes import Box
from planner.trajectory.check import check_trajectory
from planner.trajectory.export import deviation_from_curve, export, period_of, resample
from planner.trajectory.limits import USED, MotionLimits
from planner.trajectory.timing import time_path
from planner.trajectory.trajectory import Trajectory
from tests.trajectory.exact import largest_shares
from tests.worlds import load, make_post, scene_of

ARM = load("planar_2r")
FAR = scene_of((Box((0.1, 0.1, 0.1)), pose([5.0, 0.0, 0.0])))
PATH = np.array([[-1.0, 0.5], [0.0, 1.0], [1.0, 0.5], [1.2, -0.5]])
MADE = time_path(PATH, make_checker(ARM, FAR), time_law="shortcuts")
MOTIONS = [
    ("planar_2r", "blended", 120, 0.5, 0.25),
    ("panda", "blended", 12, 0.5, 0.25),
    ("panda", "stop-at-corners", 12, 0.05, 20.0),
    ("kinova", "shortcuts", 6, 0.005, 0.5),
    ("panda", "blended", 6, 5.0, 500.0),
]


@cache
def motion(robot: str, law: TimeLaw, waypoints: int, acceleration: float, jerk: float) -> Trajectory:
    arm = load(robot)
    low, high = np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0)
    path = np.random.default_rng(0).uniform(low, high, (waypoints, arm.dof))
    limits = MotionLimits.from_robot(arm, LimitsRequest(acceleration=acceleration, jerk=jerk))
    return time_path(path, make_checker(arm, FAR), limits, time_law=law)


def part(made: Trajectory, rows: int = 200) -> Trajectory:
    """The rows from its middle on: rational numbers take their time."""
    middle = slice(len(made.times) // 2, len(made.times) // 2 + rows)
    return replace(made, nanoseconds=made.nanoseconds[middle], columns=tuple(c[middle] for c in made.columns))


def shares(made: Trajectory, limits: MotionLimits | None) -> dict[str, float]:
    assert limits is not None
    return largest_shares(json.loads(export(made, "ros-json")), limits)


@pytest.mark.parametrize("rate", [7, 50, 125.0, 300, 1000, 1000.5, np.float64(240)])
def test_every_row_is_on_the_grid_to_the_nanosecond(rate: float) -> None:
    made, period = resample(MADE, rate), Fraction(10**9) / Fraction(str(rate))
    away = [abs(int(t) - k * period) for k, t in enumerate(made.nanoseconds)]
    assert max(away) <= (0 if period.denominator == 1 else Fraction(1, 2))
    assert len(away) == -(-int(MADE.nanoseconds[-1]) // period) + 3, "no knot besides, and two periods for the mean"
    for rows, ends in zip(made.columns, (MADE.columns[0][[0, -1]], 0.0, 0.0), strict=True):
        np.testing.assert_array_equal(rows[[0, -1]], np.broadcast_to(ends, (2, 2)))


@pytest.mark.parametrize("rate", [30, 333.3])
@pytest.mark.parametrize(("robot", "law", "waypoints", "acceleration", "jerk"), MOTIONS)
def test_what_a_controller_makes_of_the_rows_keeps_the_limits(
    robot: str, law: TimeLaw, waypoints: int, acceleration: float, jerk: float, rate: float
) -> None:
    """By rational numbers. Rows of the curve itself break the limit on the jerk by up to 75 %."""
    made = motion(robot, law, waypoints, acceleration, jerk)
    try:
        grid = resample(made, rate)
    except PlannerError as error:
        rate = float(str(error).split("give ")[1].split(" Hz")[0])  # the highest that rounding allows
        grid = resample(made, rate)
    found = shares(part(grid), made.limits)
    assert max(found.values()) <= 1.0 + 1e-7, found


@pytest.mark.parametrize("columns", [1, 2])
def test_lines_and_cubics_keep_what_they_say(columns: int) -> None:
    plain = Trajectory(ARM.joints, MADE.nanoseconds, MADE.columns[:columns])
    for rate in (20, 130.0, 1000):
        grid = resample(plain, rate)
        assert grid.interpolation == plain.interpolation
        for order in range(1, columns + 1):
            assert (grid.largest(order).max(axis=0) <= plain.largest(order).max(axis=0) * (1 + 1e-9) + 1e-9).all()
        np.testing.assert_array_equal(grid.columns[0][[0, -1]], plain.columns[0][[0, -1]])


@pytest.mark.parametrize("rate", [20, 100, 1000])
def test_it_leaves_the_curve_by_less_than_a_sixth_of_the_acceleration(rate: float) -> None:
    grid = resample(MADE, rate)
    assert 0 < deviation_from_curve(grid, MADE) <= 1.001 * MADE.largest(2).max() / 6 / rate**2
    t = np.linspace(0, grid.duration, 3001)
    away = np.abs(grid.at(t) - MADE.at(np.maximum(t - 1 / rate, 0))).max()
    assert away == pytest.approx(deviation_from_curve(grid, MADE), rel=0.05)


def test_it_is_proven_by_a_checker_only_and_where_it_is() -> None:
    checker = make_post()
    made = time_path(np.array([[-1.0, 0.8], [-1.1, 0.9], [-1.0, 1.0]]), checker)
    assert not resample(made, 1000).proven
    fine = resample(made, 1000, checker)
    assert made.proven
    assert fine.proven
    assert fine.limits is made.limits is not None
    assert made.limits is not None
    assert check_trajectory(checker, fine).proven


def test_what_does_not_rest_at_its_ends_is_refused() -> None:
    middle = replace(MADE, nanoseconds=MADE.nanoseconds[5:], columns=tuple(rows[5:] for rows in MADE.columns))
    with pytest.raises(PlannerError, match=r"one that begins with a velocity of .* leave --rate out"):
        resample(middle, 100)


def test_rows_nearer_than_their_rounding_allows_are_refused() -> None:
    slow = MotionLimits.from_robot(ARM, LimitsRequest(acceleration=0.1, jerk=1e-4))
    made = time_path(PATH, make_checker(ARM, FAR), slow, time_law="stop-at-corners")
    with pytest.raises(PlannerError, match=r"rate must be at most \d+\.\d Hz"):
        resample(made, 1000.0)
    assert resample(made, 50.0)


def test_bad_rates_and_too_many_rows_are_refused() -> None:
    ages = replace(MADE, nanoseconds=MADE.nanoseconds * 10**6, limits=None)
    for rate in (0.0, float("nan"), 1e6):
        with pytest.raises(PlannerError, match="rate must"):
            resample(MADE, rate)
    with pytest.raises(PlannerError, match="rate must make at most 5000000 rows"):
        resample(ages, 1000.0)


@pytest.mark.parametrize(("robot", "law", "waypoints", "acceleration", "jerk"), MOTIONS)
def test_knots_keep_the_limits(robot: str, law: TimeLaw, waypoints: int, acceleration: float, jerk: float) -> None:
    """By rational numbers, between the very nanoseconds and doubles of the file."""
    made = motion(robot, law, waypoints, acceleration, jerk)
    found = shares(part(made), made.limits)
    assert max(found.values()) <= USED + 1e-7, found


def test_a_rate_is_the_decimal_number_that_is_written() -> None:
    assert period_of(33.3) == Fraction(10**10, 333)
    assert period_of(1000.0) == 10**6
