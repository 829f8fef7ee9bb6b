"""Limits from the URDF, the robot's file, MoveIt's file and options; bad ones are refused in one sentence."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import PlannerError
from planner.problem.request import LimitsRequest
from planner.trajectory.limits import MotionLimits
from tests.worlds import ROBOTS, load

ARM = load("planar_2r")
A, B = ARM.joints


def file_of(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "joint_limits.yaml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", ROBOTS)
def test_every_robot_has_limits_and_says_where_they_come_from(name: str) -> None:
    limits = MotionLimits.from_robot(load(name))
    assert limits.joints == load(name).joints
    np.testing.assert_array_equal(limits.velocity, load(name).velocity)
    assert all(limits.source.values())
    assert ("assumed" in limits.source["acceleration"]) == (name != "panda")


def test_options_scale_and_replace() -> None:
    limits = MotionLimits.from_robot(ARM, LimitsRequest(velocity_scale=0.5, acceleration=8.0, acceleration_scale=0.25))
    np.testing.assert_allclose(limits.velocity, 0.5 * ARM.velocity)
    np.testing.assert_allclose(limits.acceleration, 2.0)
    np.testing.assert_allclose(limits.jerk, 800.0)
    assert limits.source["acceleration"] == "--acceleration 8, times 0.25"


def test_a_moveit_file_replaces_what_it_gives(tmp_path: Path) -> None:
    text = f"""
default_velocity_scaling_factor: 0.5
joint_limits:
  {B}: {{has_velocity_limits: true, max_velocity: 1.0, has_acceleration_limits: false, max_acceleration: 0}}
  {A}: {{max_acceleration: 3.0, max_velocity: 1.5}}
  finger: {{max_velocity: 0.1}}
"""
    limits = MotionLimits.from_robot(ARM, LimitsRequest(limits=file_of(tmp_path, text)))
    assert limits.velocity.tolist() == [0.75, 0.5]
    assert limits.acceleration.tolist() == [3.0, 5.0]
    assert limits.source["acceleration"].startswith("joint_limits.yaml, the rest assumed")
    whole = MotionLimits.from_robot(ARM, LimitsRequest(limits=file_of(tmp_path, text), velocity_scale=1.0))
    assert whole.velocity.tolist() == [1.5, 1.0]


def test_joints_that_a_moveit_file_does_not_name_keep_their_own_limits(tmp_path: Path) -> None:
    file = file_of(tmp_path, f"joint_limits: {{{B}: {{max_velocity: 0.5, max_effort: 1}}}}")
    limits = MotionLimits.from_robot(ARM, LimitsRequest(limits=file))
    assert limits.velocity.tolist() == [ARM.velocity[0], 0.5]
    np.testing.assert_array_equal(limits.acceleration, MotionLimits.from_robot(ARM).acceleration)
    told = f"joint_limits.yaml (efforts ignored) (without {A}), the rest URDF"
    assert limits.source["velocity"] == told


def test_what_does_not_narrow_positions_is_no_matter_and_braking_counts(tmp_path: Path) -> None:
    text = f"""
joint_limits:
  {A}: {{max_acceleration: 3.0, max_deceleration: -2.0, max_effort: 87, has_position_limits: false, max_position: 0.1}}
  {B}: {{max_acceleration: 3.0, has_deceleration_limits: false, max_deceleration: -2.0, min_position: -99}}
"""
    limits = MotionLimits.from_robot(ARM, LimitsRequest(limits=file_of(tmp_path, text)))
    assert limits.acceleration.tolist() == [2.0, 3.0]
    assert limits.source["acceleration"] == "joint_limits.yaml (efforts, wider positions ignored)"


def test_the_shares_of_a_request_come_between_a_files_factors_and_the_options(tmp_path: Path) -> None:
    text = f"default_velocity_scaling_factor: 0.5\njoint_limits: {{{A}: {{}}, {B}: {{}}}}"
    asked, file = replace(ARM, shares={"velocity": 0.25}), file_of(tmp_path, text)
    for robot, options, share in ((ARM, {}, 0.5), (asked, {}, 0.25), (asked, {"velocity_scale": 0.1}, 0.1)):
        found = MotionLimits.from_robot(robot, LimitsRequest(limits=file, **options))
        np.testing.assert_allclose(found.velocity, share * ARM.velocity)


BAD_FILES = [
    ("joint_limits: {}", f"joint '{A}' not found"),
    ("joint_limits: {finger: {max_velocity: 1}}", f"joint '{A}' not found"),
    (f"joint_limits: {{{A}: {{max_velocity: 1}}, {B}_: {{}}}}", f"joint '{B}' not found"),
    (f"joint_limits: {{{A}: {{max_velocity: 9}}, {B}: {{}}}}", "at most the URDF's 2"),
    (f"joint_limits: {{{A}: {{max_velocity: .nan}}, {B}: {{}}}}", "should be a finite number"),
    (f"joint_limits: {{{A}: {{max_acceleration: -3}}, {B}: {{}}}}", "got -3"),
    (f"joint_limits: {{{A}: {{max_velocty: 1}}, {B}: {{}}}}", "did you mean 'max_velocity'"),
    (
        f"joint_limits: {{{A}: {{has_velocity_limits: true}}, {B}: {{}}}}",
        "has_velocity_limits must come with max_velocity",
    ),
    (
        f"joint_limits: {{{A}: {{max_position: 0.5}}, {B}: {{}}}}",
        f"joint '{A}' must include .*, 0.5\\]: narrow",
    ),
    (f"joint_limits: {{{A}: {{}}, {B}: {{soft_lower_limit: 0}}}}", f"joint '{B}' must include .* got \\[0, "),
    ("joints: {}", "key 'joint_limits' not found"),
]


def test_an_option_that_no_motion_can_keep_is_refused_with_the_robot() -> None:
    with pytest.raises(PlannerError, match=f"acceleration limit of joint '{A}'") as caught:
        MotionLimits.from_robot(ARM, LimitsRequest(acceleration=1e9))
    assert caught.value.exit_code == 3


@pytest.mark.parametrize(("text", "sentence"), BAD_FILES)
def test_bad_files_are_refused(text: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(PlannerError, match=sentence) as caught:
        MotionLimits.from_robot(ARM, LimitsRequest(limits=file_of(tmp_path, text)))
    assert caught.value.exit_code == 3
    assert "\n" not in str(caught.value)


def test_a_urdf_without_velocities_gets_assumed_ones() -> None:
    limits = MotionLimits.from_robot(replace(ARM, velocity=np.array([0.0, 2.0])))
    assert limits.velocity.tolist() == [1.0, 2.0]
    assert limits.source["velocity"] == f"assumed for {A}: the URDF gives none"
