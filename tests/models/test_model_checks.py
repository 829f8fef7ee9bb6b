"""Models that load and make little sense are noticed, with a remedy."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import planner
from planner.base.errors import RobotError, StateError
from planner.base.notes import LOGGER
from planner.models.model_checks import notes
from planner.models.poses import pose
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.models.shapes import Mesh
from planner.problem.request import RoadmapRequest, WorldRequest
from planner.setup.open import make_query, open_world
from planner.setup.resolve import check_limits
from tests.models.test_solids import box
from tests.worlds import ROBOTS, joint_xml, link_xml, load, scene_of

SEEN = '<visual><geometry><sphere radius="0.1"/></geometry></visual></link>'
OPEN = Mesh(box(0.3).vertices, box(0.3).triangles[1:])


def grave(robot: Robot, scene: Scene) -> list[str]:
    return [note.text for note in notes(robot, scene) if note.grave]


@pytest.mark.parametrize("name", [name for name in ROBOTS if name != "z1"])
def test_built_in_robots_raise_no_doubt(name: str) -> None:
    assert grave(load(name), Scene.load("paper")) == []


def test_links_that_are_seen_and_cannot_be_touched() -> None:
    (text,) = grave(load("z1"), Scene.load("empty"))
    assert "no collision geometry on link01, link05" in text


def test_only_moving_links_need_geometry(urdf_file: Callable[..., str]) -> None:
    still = link_xml("a").replace("</link>", SEEN)
    inside = still + link_xml("b", '<sphere radius="0.1"/>') + joint_xml("j", "a", "b")
    assert grave(Robot.load(urdf_file(inside)), Scene.load("empty")) == []


def test_a_robot_that_nothing_can_touch_is_refused(urdf_file: Callable[..., str]) -> None:
    path = urdf_file(link_xml("a") + link_xml("b") + joint_xml("j", "a", "b"))
    with pytest.raises(RobotError, match="no collision geometry at all"):
        open_world(WorldRequest(path, "empty"))
    with pytest.raises(RobotError, match="no collision geometry at all"):
        make_query(RoadmapRequest(path, "empty", start="q:0", goal="q:1"))


@pytest.mark.parametrize(
    ("mesh", "parts"),
    [
        (box(0.3), []),
        (box(300.0), ["300 m across, and the arm is 0.9 m long: if it is in millimetres, give it 'scale: 0.001'"]),
        (box(1e-5), ["take its 'scale' away"]),
        (OPEN, ["is not closed"]),
        (Mesh(1000 * OPEN.vertices, OPEN.triangles), ["scale: 0.001", "is not closed"]),
    ],
    ids=["sound", "millimetres", "metres scaled down", "open", "both"],
)
def test_meshes_of_a_scene(mesh: Mesh, parts: list[str]) -> None:
    found = grave(load("planar_2r"), scene_of((mesh, pose([0, 0, 1000.0]))))
    assert len(found) == len(parts)
    for text, part in zip(found, parts, strict=True):
        assert part in text
        assert "'thing0'" in text


def test_a_link_in_millimetres(tmp_path: Path, urdf_file: Callable[..., str]) -> None:
    lines = ["v {} {} {}".format(*row) for row in box(100.0).vertices]
    lines += ["f {} {} {}".format(*(row + 1)) for row in box(100.0).triangles]
    (tmp_path / "link.obj").write_text("\n".join(lines) + "\n")
    links = link_xml("a") + link_xml("b", '<mesh filename="link.obj"/>') + link_xml("tip")
    robot = Robot.load(urdf_file(links + joint_xml("j", "a", "b") + joint_xml("k", "b", "tip", xyz="0.5 0 0")))
    (text,) = grave(robot, Scene.load("empty"))
    assert "link 'b' is 100 m across" in text
    assert 'scale="0.001 0.001 0.001"' in text


def test_a_library_call_holds_doubts_and_logs_them_at_debug_only(caplog: pytest.LogCaptureFixture) -> None:
    """In the plan each stands once; its log is what the command line prints."""
    home = load("z1").home
    with caplog.at_level(logging.DEBUG, "planner"):
        plan = planner.plan(robot="z1", scene="empty", start=home, goal=home + 0.1, path_only=True)
    doubts = grave(load("z1"), Scene.load("empty"))
    assert doubts
    assert [record.message for record in caplog.records if record.name == LOGGER] == doubts
    assert max(record.levelno for record in caplog.records) == logging.DEBUG
    assert set(doubts) <= set(plan.notes)
    assert list(plan.notes) == plan.to_dict()["notes"]


def test_widened_limits_are_noted() -> None:
    arm = load("iiwa14")
    goal = np.where(np.arange(7) == 6, arm.upper + 0.01, arm.home)
    plan = planner.plan(robot=arm, scene="empty", start=arm.home, goal=goal, widen_limits=True, path_only=True)
    (note,) = (note for note in plan.notes if "widened" in note)
    assert note == f"limits of {arm.joints[6]} widened to [{arm.lower[6]:.4f}, {goal[6]:.4f}]"


# degrees


def test_degrees_are_asked_about_and_never_widened_for() -> None:
    robot = load("iiwa14")
    with pytest.raises(StateError, match="degrees") as caught:
        check_limits(robot, np.array([0, 90, 0, -45, 0, 30, 0.0]), "start")
    assert "--widen-limits" not in str(caught.value)
    with pytest.raises(StateError, match=r"bring it inside, or widen them with --widen-limits\.$"):
        make_query(RoadmapRequest(start="q:0,2.5,0,-1,0,1,0"))
    request = RoadmapRequest(start="q:0,90,0,-45,0,30,0", widen_limits=True)
    with pytest.raises(StateError, match="degrees"):
        make_query(request)
