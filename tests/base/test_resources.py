"""The files that travel with the package, in a checkout and inside the wheel, and versions of software."""

from pathlib import Path

import pytest

from planner.base import resources
from planner.base.resources import robot_names, robots_folder, scene_names, scenes_folder


def test_names_are_those_of_the_files() -> None:
    assert {"iiwa14", "panda", "planar_2r"} <= set(robot_names())
    assert {"paper", "empty", "shelf"} <= set(scene_names())
    assert all((robots_folder() / name / "robot.yaml").is_file() for name in robot_names())
    assert all((scenes_folder() / f"{name}.yaml").is_file() for name in scene_names())


def test_the_wheels_own_folder_goes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "planner"
    (package / "_data" / "robots" / "arm").mkdir(parents=True)
    (package / "_data" / "robots" / "arm" / "robot.yaml").touch()
    monkeypatch.setattr(resources, "_PACKAGE", package)
    assert robot_names() == ["arm"]
    assert scenes_folder() == tmp_path / "scenes"
