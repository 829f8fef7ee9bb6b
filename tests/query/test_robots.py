"""A robot by name is read once, and again as soon as one of its files is touched."""

import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from planner.base.resources import robots_folder
from planner.problem.request import WorldRequest
from planner.query.query import make_checker_for
from planner.query.robots import robot_of
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from tests.worlds import joint_xml, link_xml


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
    assert make_checker_for(WorldRequest(str(arm / "robot.yaml"), Scene("empty"))).robot is robot(arm)


@pytest.mark.parametrize("name", ["robot.yaml", "*.urdf"])
def test_a_file_that_is_touched_is_read_again(arm: Path, name: str) -> None:
    known, file = robot(arm), next(arm.glob(name))
    file.write_text(file.read_text() + "\n")
    assert robot(arm) is not known
    np.testing.assert_array_equal(robot(arm).lower, known.lower)


@pytest.mark.parametrize("in_place", [False, True])
def test_a_change_is_seen_even_at_the_same_time_and_length(in_place: bool, arm: Path) -> None:
    known, file = robot(arm), next(arm.glob("*.urdf"))
    text = file.read_text()
    limit = text[text.index('upper="') :].split('"')[1]
    other = file if in_place else arm / "other"
    other.write_text(text.replace(f'upper="{limit}"', f'upper="{"1" + limit[1:]}"'))
    os.utime(other, (1e9, 1e9))
    other.replace(file)
    assert not np.array_equal(robot(arm).upper, known.upper)


SINGULAR = {  # axes and steps: at zero joints 1 and 3 are parallel, or the arm is stretched out above its base
    "wrist": (("0 0 1", "0 1 0", "0 0 1"), "0.1 0 0.4"),
    "arm": (("0 0 1", "0 1 0", "0 1 0"), "0 0 0.4"),
}


@pytest.mark.parametrize(("axes", "step"), SINGULAR.values(), ids=SINGULAR)
def test_home_is_free_and_not_singular_where_no_file_says_where_it_is(
    axes: tuple[str, str, str], step: str, urdf_file: Callable[..., str]
) -> None:
    """FCL says that it is free; w is compared with that of random configurations by Pinocchio's Jacobian."""
    rod = '<capsule radius="0.02" length="0.2"/>', '<origin xyz="0 0 0.2"/>'
    links = "".join(link_xml(f"l{k}", *rod) for k in range(4)) + link_xml("tip")
    joints = "".join(joint_xml(f"j{k}", f"l{k}", f"l{k + 1}", axis=axis, xyz=step) for k, axis in enumerate(axes))
    file = urdf_file(links + joints + joint_xml("end", "l3", "tip", "fixed", xyz=step))
    checker = make_checker_for(WorldRequest(file, "empty"))
    robot, (note,) = checker.robot, checker.robot.notes
    assert "No file has a home" in note.text
    assert f"home is q:{','.join(f'{value:g}' for value in robot.home.tolist())} instead" in note.text
    assert checker.first_contact(robot.home[None]) is None
    random = np.random.default_rng(5).uniform(robot.lower, robot.upper, size=(200, 3))
    assert w_of(robot, robot.home) > 0.5 * np.median([w_of(robot, q) for q in random])
    assert w_of(robot, np.zeros(3)) < 1e-9
    assert (Robot.load(file).home == 0).all()  # as its files have it


def w_of(robot: Robot, q: np.ndarray) -> float:
    """The product of the singular values of the tool's Jacobian, its three rows of translation."""
    data = robot.model.createData()
    jacobian = pin.computeFrameJacobian(
        robot.model, data, q, robot.model.getFrameId(robot.tool), pin.LOCAL_WORLD_ALIGNED
    )
    return float(np.linalg.svd(jacobian[:3], compute_uv=False).prod())
