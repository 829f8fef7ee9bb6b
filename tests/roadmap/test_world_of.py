"""The world that a plan was made in."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.base.errors import FileError
from planner.problem.request import PlanRequest, WorldRequest
from planner.query.query import open_world
from planner.roadmap.build import build_roadmap
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import same_world, save_roadmap
from planner.roadmap.world_of import reopen_plan


def of_window(margin: float = 0.01) -> Roadmap:
    """A roadmap of built-in names."""
    checker = open_world(WorldRequest("planar_2r", "window", margin=margin))
    return build_roadmap(checker.robot, checker, [0.0, 0.5], [0.1, 0.5], nodes=6)


def test_a_plans_world_is_the_one_that_its_roadmap_was_proven_in(tmp_path: Path) -> None:
    roadmap, file = of_window(), tmp_path / "roadmap.npz"
    save_roadmap(roadmap, file)
    config = PlanRequest.from_options(robot="planar_2r", scene="window", margin=0.01).config()
    assert same_world(roadmap, reopen_plan(config, file))
    for other in ({"scene": "empty"}, {"margin": 0.02}, {"base": "0,0,1"}):
        with pytest.raises(FileError, match=r"was proven for another robot or scene than its plan\.json names"):
            reopen_plan(config | other, file)
    with pytest.raises(FileError, match=r"options in the plan.json next to .* are not valid"):
        reopen_plan(config | {"margin": "wide"}, file)
