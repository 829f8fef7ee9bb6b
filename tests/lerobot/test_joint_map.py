"""Columns and units: what is sent is what LeRobot's motors count, and columns without a joint pass through."""

import numpy as np
import pytest

from planner.base.errors import OptionError
from planner.lerobot import JointMap
from tests.lerobot.conftest import NAMES
from tests.worlds import load

ARM = load("so101")
COUNTS = 4096  # of a turn of the encoder


def lerobot_value(rad: float, low: float, high: float, units: str) -> float:
    """What lerobot's motor bus reports of a joint at ``rad``, by way of the encoder, calibrated from low to high."""
    least, most = (COUNTS / 2 + end / (2 * np.pi) * (COUNTS - 1) for end in (low, high))
    count = COUNTS / 2 + rad / (2 * np.pi) * (COUNTS - 1)
    if units == "normalized":
        return (count - least) / (most - least) * 200 - 100
    middle = COUNTS / 2  # of a range that is as far to both sides
    return (count - middle) * 360 / (COUNTS - 1)


@pytest.mark.parametrize("units", ["degrees", "normalized"])
def test_values_of_the_motor_bus_become_rad_and_back(units: str) -> None:
    joints = JointMap.from_limits(NAMES, ARM.joints, ARM.lower, ARM.upper, units)
    q = np.random.default_rng(0).uniform(ARM.lower, ARM.upper, (20, 5))
    rows = np.full((20, 6), 37.0)
    for k, (low, high) in enumerate(zip(ARM.lower, ARM.upper, strict=True)):
        if ARM.joints[k] == "wrist_roll":  # lerobot calibrates it as a full turn
            low, high = -np.pi, np.pi
        rows[:, k] = [lerobot_value(value, low, high, units) for value in q[:, k]]
    np.testing.assert_allclose(joints.to_joints(rows), q, atol=1e-9)
    np.testing.assert_allclose(joints.replace(np.full((20, 6), 37.0), q), rows, atol=1e-9)


def test_columns_in_any_order_with_other_names() -> None:
    names = ["gripper.pos", "b", "wrist_roll.pos", "shoulder_lift.pos", "elbow_flex.pos", "wrist_flex.pos", "x"]
    joints = JointMap.from_limits(names, ARM.joints, ARM.lower, ARM.upper, "rad", renamed={"b": "shoulder_pan"})
    row = np.arange(7.0)[None]
    assert joints.to_joints(row).tolist() == [[1.0, 3.0, 4.0, 5.0, 2.0]]
    assert joints.replace(row, np.full((1, 5), 9.0)).tolist() == [[0.0, 9.0, 9.0, 9.0, 9.0, 9.0, 6.0]]


def test_a_span_of_ones_own() -> None:
    joints = JointMap.from_limits(NAMES, ARM.joints, ARM.lower, ARM.upper, "normalized", {"elbow_flex": (-1.0, 3.0)})
    assert joints.to_joints(np.full((1, 6), 50.0))[0, 2] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"units": "turns"}, "units must be one of degrees, normalized, rad, got 'turns'"),
        ({"renamed": {"elbow": "elbow_flex"}}, "renamed must name"),
        ({"spans": {"elbow": (0.0, 1.0)}}, "spans must name"),
        ({"names": NAMES[1:]}, "must have one column of joint 'shoulder_pan'"),
        ({"names": [*NAMES, NAMES[2]]}, "must have one column of joint 'elbow_flex'"),
        ({"units": "normalized", "upper": np.full(5, np.inf)}, "spans must have"),
    ],
)
def test_what_does_not_fit_is_refused(options: dict, words: str) -> None:
    given = {"names": NAMES, "joints": ARM.joints, "lower": ARM.lower, "upper": ARM.upper} | options
    with pytest.raises(OptionError, match=words):
        JointMap.from_limits(**given)
