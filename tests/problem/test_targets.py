"""Targets as people write them."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from planner.base.errors import OptionError
from planner.problem.conditions import AxisConstraint
from planner.problem.targets import (
    Joints,
    Named,
    Pose,
    Position,
    ToolGoal,
    parse_base,
    parse_target,
    parse_targets,
    read_goals,
    read_target,
)
from tests.random_shapes import QUICK

NUMBERS = st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=9)


def test_goals_of_equal_right():
    assert parse_targets("goal") == (Named(("goal",)),)
    assert parse_targets("xyz:1,2,3 ; left, right;q:1") == (
        Position((1, 2, 3)),
        Named(("left",)),
        Named(("right",)),
        Joints((1.0,)),
    )
    with pytest.raises(OptionError, match="got an empty text"):
        parse_targets("goal;")


def test_targets_name_their_frame_before_or_behind():
    left, turned = Position((1.0, 2.0, 3.0), "left"), Pose((1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0), "right")
    assert parse_target("left xyz:1,2,3") == parse_target("xyz:1,2,3 of left") == parse_target(left.text) == left
    assert parse_target("right  pose:1,2,3,0,0,0,1") == parse_target(turned.text) == turned
    both = parse_target("left xyz:1,2,3 & right pose:1,2,3,0,0,0,1")
    assert both == ToolGoal("xyz:1,2,3", tool="left") & ToolGoal(turned) == parse_target(both.text)
    assert both.exact == (left, turned)
    assert parse_target(f"{both.text} & axis:z,0,0,1,0.1").exact == ()
    assert parse_target("left box:0,0,0,1,1,1 & xyz:1,2,3").exact == ()
    assert ToolGoal("axis:z,0,0,1,0.1 of hand", tool="left").conditions[0].frame == "hand"
    assert parse_target("left plane:0,0,1,0.1 at 1,2,3").text == "plane:0,0,1,0.1 of left at 1,2,3"


@pytest.mark.parametrize(
    "text", ["left xyz:1,2,3 of right", "left axis:z,0,0,1,0.1 of right", "left q:1,2", "q:1 of left"]
)
def test_a_target_of_two_frames_or_joints_of_a_frame_is_refused(text):
    with pytest.raises(OptionError):
        parse_target(text)


@QUICK
@given(NUMBERS)
def test_numbers_come_back_to_the_last_bit(values):
    assert parse_target("q:" + ",".join(map(repr, values))) == Joints(tuple(values))


@QUICK
@given(st.text(max_size=30))
def test_any_text_is_a_target_or_an_option_error(text):
    try:
        target = parse_target(text)
    except OptionError:
        return
    assert isinstance(target, Joints | Position | Pose | Named)


@QUICK
@given(st.integers(0, 2**31))
def test_matrices_are_poses_and_lists_are_joint_values(seed):
    position, turn = np.random.default_rng(seed).normal(size=(2, 3))
    placement = pin.SE3(Rotation.from_rotvec(turn).as_matrix(), position)
    for matrix in (placement, placement.homogeneous):
        found = read_target(matrix)
        np.testing.assert_allclose(found.xyz, placement.translation, atol=0)
        np.testing.assert_allclose(Rotation.from_quat(found.quaternion).as_matrix(), placement.rotation, atol=1e-12)
        assert read_goals([matrix, "home", matrix]) == (found, Named(("home",)), found)
        axis = AxisConstraint("z", (0.0, 0.0, 1.0), 0.1)
        assert ToolGoal((matrix, axis)) == parse_target(f"{found.text} & {axis.text}")
        assert ToolGoal(matrix).conditions == parse_target(f"{found.text} & {found.text}").conditions[:2]
        *position, r, p, y = parse_base(matrix)
        np.testing.assert_allclose(position, placement.translation, atol=0)
        np.testing.assert_allclose(Rotation.from_euler("xyz", [r, p, y]).as_matrix(), placement.rotation, atol=1e-12)
    rows = np.zeros((4, 4)).tolist()  # of four joints each
    assert read_goals(rows) == (Joints((0.0, 0.0, 0.0, 0.0)),) * 4
    assert read_goals(list(np.zeros((4, 4)))) == read_goals(rows)


@pytest.mark.parametrize(
    "matrix", [np.zeros((4, 4)), np.diag([1, 1, -1, 1]), np.eye(4) + 1e-3, np.full((4, 4), np.nan)]
)
@pytest.mark.parametrize("read", [read_target, read_goals, parse_base, ToolGoal])
def test_a_matrix_that_is_not_rigid_is_refused(matrix, read):
    with pytest.raises(OptionError, match=r"the \(4, 4\) pose given as .*\.$") as caught:
        read(matrix)
    assert "\n" not in str(caught.value)
