"""Generated grasps: fingers close across the object, the tool comes from outside, and nothing wider is held."""

import numpy as np
import pytest

from planner.robot.poses import pose
from planner.robot.shapes import Box, Capsule, Cylinder, Obstacle, Sphere
from planner.tasks.sampling import MOST, complete_gripper, extent, generate_grasps, place_in_region
from planner.tasks.task import Gripper, Place, TaskError
from tests.worlds import load

SHAPES = {
    "box": Box((0.05, 0.12, 0.07)),
    "cylinder": Cylinder(0.03, 0.12),
    "sphere": Sphere(0.035),
    "capsule": Capsule(0.02, 0.1),
}


def gaps(shape, pose_: np.ndarray) -> np.ndarray:
    """How far the object reaches from the tool's origin along the tool's -y, y and against its approach, by points."""
    rng = np.random.default_rng(0)
    low, high = extent(shape, np.eye(3))
    points = rng.uniform(low, high, (60_000, 3))
    inside = {
        Box: lambda p: np.ones(len(p), bool),
        Sphere: lambda p: np.linalg.norm(p, axis=1) <= shape.radius,
        Cylinder: lambda p: np.hypot(p[:, 0], p[:, 1]) <= shape.radius,
        Capsule: lambda p: (
            np.linalg.norm(
                p - np.column_stack([0 * p[:, 0], 0 * p[:, 0], p[:, 2].clip(-shape.length / 2, shape.length / 2)]),
                axis=1,
            )
            <= shape.radius
        ),
    }[type(shape)]
    seen = (points[inside(points)] - pose_[:3, 3]) @ pose_[:3, :3]
    between = seen[(np.abs(seen[:, 0]) < 0.005) & (np.abs(seen[:, 2]) < 0.005)]  # what the pads would meet
    return np.array([-between[:, 1].min(), between[:, 1].max(), -seen[:, 2].min()])


@pytest.mark.parametrize("name", SHAPES)
def test_fingers_close_across_the_object(name: str) -> None:
    shape = SHAPES[name]
    found = generate_grasps(name, shape, 0.08)
    assert 40 <= len(found) <= MOST
    assert len({grasp.tool.round(9).tobytes() for grasp in found}) == len(found)
    for grasp in found[:: max(1, len(found) // 25)]:
        turn = grasp.tool[:3, :3]
        np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) == pytest.approx(1.0)
        assert grasp.opening is not None
        assert grasp.opening <= 0.078
        left, right, behind = gaps(shape, grasp.tool)
        assert left == pytest.approx(right, abs=0.012)  # the tool is in the middle between the fingers
        assert left + right <= grasp.opening + 1e-3
        assert 0.0 < behind <= 0.06  # towards the palm the object ends soon


def test_what_is_too_wide_is_refused_and_a_box_is_held_by_its_narrow_sides_only() -> None:
    for shape in (Box((0.1, 0.1, 0.1)), Sphere(0.05), Cylinder(0.05, 0.1), Capsule(0.05, 0.1)):
        with pytest.raises(TaskError, match=r"'it' must be narrower than the gripper's opening of 0.08 m"):
            generate_grasps("it", shape, 0.08)
    for grasp in generate_grasps("it", Box((0.05, 0.12, 0.2)), 0.08):
        np.testing.assert_allclose(np.abs(grasp.tool[:3, 1]), [1, 0, 0], atol=1e-12)


def test_the_pandas_gripper_is_read_from_its_joints() -> None:
    found = complete_gripper(load("panda"), Gripper())
    assert found.opening == pytest.approx(0.08)
    assert found.touch == ("panda_leftfinger", "panda_rightfinger")
    assert found.values(0.02) == pytest.approx({"panda_finger_joint1": 0.01, "panda_finger_joint2": 0.01})
    assert found.values(None) == pytest.approx({"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0})
    said = complete_gripper(load("panda"), Gripper(opening=0.05, touch=("panda_hand",)))
    assert (said.opening, said.touch) == (0.05, ("panda_hand",))
    bare = complete_gripper(load("iiwa14"), Gripper())
    assert (bare.open, bare.opening, len(bare.touch or ())) == ({}, None, 1)


@pytest.mark.parametrize("name", SHAPES)
def test_placements_lie_within_the_region_and_touch_nothing(name: str) -> None:
    board = Obstacle("board", Box((0.5, 0.6, 0.02)), pose((0.4, 0.1, 0.3)))
    item = Obstacle(name, SHAPES[name], pose((0, 0, 0), rpy=(0.5, 0.2, 0.1)))
    step = Place(name, "board", ((0.2, 0.0), (0.5, 0.25)), samples=12)
    places = place_in_region(item, step, [board], margin=0.0)
    assert len(places) == 12
    assert len({place.pose.round(6).tobytes() for place in places}) == 12
    for place in places:
        low, high = (end + place.pose[:3, 3] for end in extent(item.shape, place.pose[:3, :3]))
        assert (low[:2] >= np.array([0.2, 0.0]) - 1e-12).all()
        assert (high[:2] <= np.array([0.5, 0.25]) + 1e-12).all()
        assert low[2] == pytest.approx(0.311)
        np.testing.assert_allclose(place.pose[2, :3], item.placement[2, :3], atol=1e-12)  # turned about z alone
    again = place_in_region(item, step, [board], margin=0.0)
    assert all(np.array_equal(a.pose, b.pose) for a, b in zip(places, again, strict=True))
