"""Robots by the names of robot_descriptions: a stand-in for that package, which downloads where ours must not."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from planner.base.errors import InstallationError, RobotError
from planner.robot.files import descriptions
from planner.robot.files.robot_files import read_robot
from planner.robot.robot import Robot
from tests.worlds import joint_xml, link_xml

CACHE = "def clone_to_cache(name, commit=None):\n    raise AssertionError('it downloads')\n"
REPOSITORIES = "class R:\n    cache_path = 'stored'\nREPOSITORIES = {'one': R}\n"
MODULE = """from os import path
from ._cache import clone_to_cache as _clone_to_cache
REPOSITORY_PATH = _clone_to_cache("one", commit=None)
"""


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of that name, and its cache in the folder that this is."""
    folder, cache = tmp_path / "site" / "robot_descriptions", tmp_path / "cache"
    folder.mkdir(parents=True)
    for name, text in (("__init__", ""), ("_cache", CACHE), ("_repositories", REPOSITORIES)):
        (folder / f"{name}.py").write_text(text)
    (folder / "arm_description.py").write_text(
        MODULE
        + 'URDF_PATH = path.join(REPOSITORY_PATH, "arm.urdf")\nSRDF_PATH = path.join(REPOSITORY_PATH, "a.srdf")\n'
    )
    (folder / "bare_description.py").write_text(MODULE)
    (folder / "xacro_description.py").write_text(
        MODULE + 'XACRO_PATH = path.join(REPOSITORY_PATH, "arm.xacro")\nXACRO_ARGS = {"kind": "x"}\n'
    )
    monkeypatch.syspath_prepend(str(folder.parent))
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(cache))
    before = {name for name in sys.modules if name.startswith("robot_descriptions")}
    for name in before:
        monkeypatch.delitem(sys.modules, name)
    yield cache / "stored"
    for name in [name for name in sys.modules if name.startswith("robot_descriptions")]:
        del sys.modules[name]


def fill(folder: Path) -> None:
    folder.mkdir(parents=True)
    links = link_xml("a") + link_xml("b", '<sphere radius="0.1"/>') + joint_xml("j", "a", "b")
    (folder / "arm.urdf").write_text(f'<robot name="own">{links}</robot>')
    (folder / "a.srdf").write_text('<robot name="own"><disable_collisions link1="a" link2="b"/></robot>')


def test_a_robot_that_is_there(package: Path) -> None:
    fill(package)
    robot = Robot.load("arm_description")
    assert (robot.name, robot.joints) == ("arm_description", ("j",))
    files = read_robot("arm_description")
    assert files.disabled_pairs == frozenset({frozenset("ab")})
    found = descriptions.described("xacro_description")
    assert (found.file, found.arguments) == (package / "arm.xacro", {"kind": "x"})


def test_nothing_is_downloaded(package: Path) -> None:
    with pytest.raises(RobotError, match="run 'python -m robot_descriptions pull arm_description' once"):
        Robot.load("arm_description")
    fill(package)
    assert Robot.load("arm_description").joints == ("j",), "and once it is there it is found"


def test_names_and_files_that_are_not_there(package: Path) -> None:
    fill(package)
    with pytest.raises(RobotError, match="is not in robot_descriptions"):
        Robot.load("none_description")
    with pytest.raises(RobotError, match="has neither URDF, xacro nor MJCF"):
        Robot.load("bare_description")


def test_without_the_package_the_command_that_helps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(descriptions, "_PACKAGE", "robot_descriptions_that_nobody_has")
    with pytest.raises(InstallationError, match=r"pip install 'gabf-planner\[descriptions\]'"):
        Robot.load("arm_description")
    with pytest.raises(RobotError, match="not found; robots are"):
        Robot.load("arm")
