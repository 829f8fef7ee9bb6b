"""Exports read back: what a controller interpolates between their points is what was proven, in every format."""

from __future__ import annotations

import json
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import yaml

from planner.base.errors import PlannerError
from planner.collision import make_checker
from planner.models.poses import pose
from planner.models.shapes import Box
from planner.trajectory.export import SUFFIX, Format, export, goal_command
from planner.trajectory.points import read_points
from planner.trajectory.timing import time_path
from planner.trajectory.trajectory import Trajectory
from tests.worlds import load, scene_of

ARM = load("planar_2r")
A, B = ARM.joints
PATH = np.array([[-1.0, 0.5], [0.0, 1.0], [1.0, 0.5], [1.2, -0.5]])
FAR = scene_of((Box((0.1, 0.1, 0.1)), pose([5.0, 0.0, 0.0])))
MADE = time_path(PATH, make_checker(ARM, FAR), law="shortcuts")
needs_mcap = pytest.mark.skipif(find_spec("mcap") is None, reason="the extra mcap is not installed")
FORMATS = [pytest.param(kind, marks=needs_mcap) if kind == "mcap" else kind for kind in get_args(Format)]


def read_back(content: bytes, kind: Format, folder: Path) -> Trajectory:
    path = folder / f"back.{SUFFIX[kind]}"
    path.write_bytes(content)
    points = read_points(path, ARM)
    assert points is not None
    assert points.fault() is None
    return points.trajectory()


@pytest.mark.parametrize("kind", FORMATS)
def test_every_format_gives_the_same_polynomials(kind: Format, tmp_path: Path) -> None:
    found = read_back(export(MADE, kind), kind, tmp_path)
    np.testing.assert_array_equal(found.nanoseconds, MADE.nanoseconds)
    np.testing.assert_array_equal(found.coefficients, MADE.coefficients)


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("given", [1, 2])
def test_what_has_no_accelerations_is_not_given_any(given: int, kind: Format, tmp_path: Path) -> None:
    """A controller would run other polynomials if it were."""
    still = [0.0 * MADE.knots(1)] * (given - 1)
    plain = Trajectory.through(ARM.joints, MADE.times, MADE.knots(), *still)
    found = read_back(export(plain, kind), kind, tmp_path)
    assert found.interpolation == plain.interpolation == ("lines", "cubics")[given - 1]
    np.testing.assert_allclose(found.coefficients, plain.coefficients, atol=1e-14)


def test_the_first_point_can_be_left_out(tmp_path: Path) -> None:
    found = read_back(export(MADE, "ros-json", skip_first_point=True), "ros-json", tmp_path)
    np.testing.assert_allclose(found.times, MADE.times[1:], rtol=1e-15)
    np.testing.assert_allclose(found.coefficients, MADE.coefficients[1:], atol=1e-14)


@pytest.mark.parametrize("kind", ["ros-yaml", "ros-json", "moveit"])
def test_ros_reads_the_messages_as_yaml(kind: Format) -> None:
    """ROS reads YAML 1.1, to which 1e-09 is a text."""
    tiny = replace(MADE, columns=tuple(1e-9 * rows for rows in MADE.columns))
    message = yaml.safe_load(export(tiny, kind))
    message = message.get("joint_trajectory", message)
    assert message["joint_names"] == [A, B]
    times = [p["time_from_start"]["sec"] * 10**9 + p["time_from_start"]["nanosec"] for p in message["points"]]
    assert all(0 <= p["time_from_start"]["nanosec"] < 10**9 for p in message["points"])
    assert (np.diff(times) > 0).all()
    assert message["points"][-1]["velocities"] == [0.0, 0.0]
    values = [v for p in message["points"] for v in (*p["positions"], *p["velocities"])]
    assert all(isinstance(value, float) for value in values)
    assert json.loads(export(tiny, "ros-json"))["points"] == message["points"]


def test_overlong_motions_are_refused() -> None:
    with pytest.raises(PlannerError, match="a ROS duration holds"):
        export(replace(MADE, nanoseconds=MADE.nanoseconds * 10**9 * 2), "ros-yaml")


@pytest.mark.parametrize("name", ["a,b", 'a"', "a\nb"])
def test_a_csv_has_a_column_for_each_joint(name: str) -> None:
    with pytest.raises(PlannerError, match="for which csv has no place: choose another"):
        export(replace(MADE, joints=(name, B)), "csv")


def test_the_goal_is_sent_with_one_command() -> None:
    command = goal_command(Path("a b.json"))
    assert command.startswith("ros2 action send_goal /joint_trajectory_controller/follow_joint_trajectory")
    assert "$(cat 'a b.json')" in command
