"""The world of a kept roadmap: its file's own, but for what is asked for otherwise."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import FileError
from planner.construction.build import build_roadmap
from planner.construction.world_of import reopen, reopen_plan
from planner.models.robot import with_widened_limits
from planner.problem.request import KeptRequest, WorldRequest
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import same_world, save_roadmap
from planner.setup.open import open_world
from tests.worlds import load, post_roadmap

FILE = Path("kept.npz")


def of_window(margin: float = 0.01) -> Roadmap:
    """A roadmap of built-in names."""
    checker = open_world(WorldRequest("planar_2r", "window", margin=margin))
    return build_roadmap(checker.robot, checker, [0.0, 0.5], [0.1, 0.5], nodes=6)


def test_built_in_names_and_the_margin_are_the_files() -> None:
    roadmap = of_window()
    checker = reopen(KeptRequest(), roadmap, FILE)
    assert same_world(roadmap, checker)
    assert checker.world.margin == 0.01
    assert reopen(KeptRequest(margin=0.0, collision="coal"), roadmap, FILE).world.margin == 0.0


def test_what_is_not_built_in_has_to_be_named() -> None:
    with pytest.raises(FileError, match="is for scene 'made', which is not built in: say where it is with --scene"):
        reopen(KeptRequest(), post_roadmap(), FILE)


def test_another_robot_is_refused() -> None:
    with pytest.raises(FileError, match="is for robot 'planar_2r', not 'ur5'"):
        reopen(KeptRequest(robot="ur5", tool="tool0"), of_window(), FILE)


def test_limits_are_widened_where_that_is_asked_for() -> None:
    roadmap, robot = of_window(), load("planar_2r")
    wide = with_widened_limits(robot, np.array([robot.upper + 0.2]))
    grown = replace(
        roadmap,
        origin=replace(
            roadmap.origin, world=replace(roadmap.origin.world, upper=tuple(wide.upper), lower=tuple(wide.lower))
        ),
    )
    assert reopen(KeptRequest(), grown, FILE).robot.upper.tolist() == robot.upper.tolist()
    np.testing.assert_allclose(reopen(KeptRequest(widen_limits=True), grown, FILE).robot.upper, wide.upper)


def test_a_plans_world_is_the_one_that_its_roadmap_was_proven_in(tmp_path: Path) -> None:
    roadmap, file = of_window(), tmp_path / "roadmap.npz"
    save_roadmap(roadmap, file)
    config = WorldRequest("planar_2r", "window", margin=0.01).to_dict()
    assert same_world(roadmap, reopen_plan(config, file))
    for other in ({"scene": "empty"}, {"margin": 0.02}, {"base": "0,0,1"}):
        with pytest.raises(FileError, match=r"roadmap .* (is for|was proven with)"):
            reopen_plan(config | other, file)
    with pytest.raises(FileError, match=r"options in the plan.json beside .* are not what a plan writes"):
        reopen_plan(config | {"margin": "wide"}, file)
