"""A robot by name is read once, and again as soon as one of its files is touched."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path

import numpy as np
import pytest

from planner.base.resources import robots_folder
from planner.problem.request import WorldRequest
from planner.query.query import open_world
from planner.query.robots import robot_of
from planner.robot.robot import Robot
from planner.robot.scene import Scene


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """A robot of its own, whose files were there long before the test."""
    made = tmp_path / "arm"
    shutil.copytree(robots_folder() / "planar_2r", made)
    for path in made.rglob("*"):
        os.utime(path, (1e9, 1e9))
    time.sleep(0.03)  # times of files are as coarse as the kernel's clock
    return made


def robot(folder: Path, base: tuple[float, ...] | None = None) -> Robot:
    return robot_of(WorldRequest(str(folder / "robot.yaml"), base=base), Scene("empty"), None)


def test_it_is_the_same_object_for_the_same_request(arm: Path) -> None:
    assert robot(arm) is robot(arm)
    based = robot(arm, base=(0.1, 0, 0, 0, 0, 0))
    assert based is not robot(arm)
    assert based.base[0, 3] == 0.1
    assert open_world(WorldRequest(str(arm / "robot.yaml"), Scene("empty"))).robot is robot(arm)


@pytest.mark.parametrize("name", ["robot.yaml", "*.urdf"])
def test_a_file_that_is_touched_is_read_again(arm: Path, name: str) -> None:
    known, file = robot(arm), next(arm.glob(name))
    file.write_text(file.read_text() + "\n")
    assert robot(arm) is not known
    np.testing.assert_array_equal(robot(arm).lower, known.lower)


@pytest.mark.parametrize("in_place", [False, True])
def test_what_changed_is_seen_even_at_the_same_time_and_length(in_place: bool, arm: Path) -> None:
    known, file = robot(arm), next(arm.glob("*.urdf"))
    text = file.read_text()
    limit = text[text.index('upper="') :].split('"')[1]
    other = file if in_place else arm / "other"
    other.write_text(text.replace(f'upper="{limit}"', f'upper="{"1" + limit[1:]}"'))
    os.utime(other, (1e9, 1e9))
    other.replace(file)
    assert not np.array_equal(robot(arm).upper, known.upper)
