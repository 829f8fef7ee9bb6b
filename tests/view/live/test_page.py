"""The live page: a change is planned as the session plans it, or refused and nothing has changed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner.collision import make_checker
from planner.kinematics.forward import tool_positions
from planner.planning.plan import plan
from planner.problem.request import PlanRequest
from planner.robot.scene import Scene
from planner.session.session import Session
from planner.trajectory.measure import path_contact
from planner.view.live import GOAL, LivePage, Question
from tests.worlds import load

SCENE = """
obstacles:
  - {name: post, type: box, size: [0.1, 0.04, 0.2], position: [0.75, 0, 0]}
  - {name: drum, type: cylinder, radius: 0.05, length: 0.2, position: [-0.5, -0.8, 0.1]}
states: {planar_2r: {start: "q:-1.0,0.8", goal: "q:1.0,-0.8"}}
"""
UPRIGHT = [0.0, 0.0, 0.0, 1.0]


@pytest.fixture
def page(tmp_path: Path) -> Iterator[LivePage]:
    (tmp_path / "scene.yaml").write_text(SCENE)
    session = Session("planar_2r", str(tmp_path / "scene.yaml"), nodes=80, join_motions=500)
    page = LivePage(session, Question("start", "goal", 0.5), tmp_path / "saved.yaml")
    yield page
    page.close()


def put(page: LivePage, name: str, *position: float) -> None:
    page.move(name, np.array(position), UPRIGHT)


def shown(page: LivePage) -> list[Any]:
    """All that the page shows of the answer."""
    things = [*page._picture.obstacles.values(), page._goal, page._gizmo, *page._picture._frames]
    places = [[*thing.position.tolist(), *thing.wxyz.tolist()] for thing in things]
    return [places, page.start.value, page.beta.value, page.answers[-1].plan.path.tolist()]


def assert_free_by_the_other_checker(page: LivePage) -> None:
    found = page.answers[-1].plan
    assert found.solved
    other = make_checker(load("planar_2r"), page._session.scene, "coal")
    assert path_contact(other, found.path) is None


def test_a_moved_obstacle_is_planned_around_and_undone(page: LivePage) -> None:
    before = shown(page)
    put(page, "post", 0.6, 0.0, 0.0)
    assert page._picture.obstacles["post"].position.tolist() == [0.6, 0.0, 0.0]
    assert path_contact(make_checker(load("planar_2r"), page._session.scene, "coal"), np.array(before[-1])) is not None
    assert_free_by_the_other_checker(page)
    assert "A collision-free path was found." in page.outcome.value
    cost = page.answers[-1].plan.cost
    assert f"cost {cost.total:.4f}" in page.outcome.value
    assert "clearance" in page.outcome.value
    page.undo()
    assert shown(page) == before
    page.undo()  # there is nothing left
    assert shown(page) == before


def test_a_moved_goal_is_reached(page: LivePage) -> None:
    put(page, GOAL, 0.3, 0.6, 0.0)
    assert page.answers[-1].question.goal == "xyz:0.3,0.6,0.0"
    np.testing.assert_allclose(
        tool_positions(load("planar_2r"), page.answers[-1].plan.path)[-1, :2], [0.3, 0.6], atol=1e-5
    )
    np.testing.assert_allclose(page._goal.position[:2], [0.3, 0.6], atol=1e-5)
    assert_free_by_the_other_checker(page)


@pytest.mark.parametrize(
    ("name", "position", "words"),
    [("post", (0.5, -0.5, 0.0), "touch"), (GOAL, (3.0, 0.0, 0.0), "reach"), ("nothing", (1, 1, 0), "'nothing'")],
)
def test_a_change_that_cannot_be_is_refused(page: LivePage, name: str, position: tuple[float, ...], words: str) -> None:
    """An obstacle where the arm starts, a goal out of reach, an obstacle that is not there."""
    before = shown(page)
    put(page, name, *position)
    assert words in page.outcome.value
    assert shown(page) == before
    put(page, "drum", -0.5, 0.8, 0.1)
    assert_free_by_the_other_checker(page)


def test_a_saved_scene_is_planned_to_the_same_ends(page: LivePage, tmp_path: Path) -> None:
    put(page, "drum", -0.5, 0.8, 0.1)
    put(page, GOAL, 0.3, 0.6, 0.0)
    page.save()
    assert f"Written: {tmp_path / 'saved.yaml'}" in page.outcome.value
    again = Scene.load(str(tmp_path / "saved.yaml"))
    np.testing.assert_allclose(again.obstacles[1].placement, page._session.scene.obstacles[1].placement)
    found = plan(
        request=PlanRequest.from_options(robot="planar_2r", scene=str(tmp_path / "saved.yaml"), nodes=80), timing=None
    )
    np.testing.assert_allclose(found.path[0], [-1.0, 0.8])
    np.testing.assert_allclose(tool_positions(load("planar_2r"), found.path)[-1, :2], [0.3, 0.6], atol=1e-5)
