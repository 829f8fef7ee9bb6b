"""Models that load and make little sense are noticed, with a remedy."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml

import planner
from planner.base.errors import LOGGER, RobotError, StateError
from planner.base.resources import published_scene_names, scene_names
from planner.problem.request import RoadmapRequest, WorldRequest
from planner.query.query import make_query, open_world
from planner.query.resolve import check_limits
from planner.robot.model_checks import notes
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Mesh
from tests.robot.test_solids import box
from tests.worlds import ROBOTS, joint_xml, link_xml, load, scene_of

OPEN = Mesh(box(0.3).vertices, box(0.3).triangles[1:])


def grave(robot: Robot, scene: Scene) -> list[str]:
    return [note.text for note in notes(robot, scene) if note.grave]


@pytest.mark.parametrize("name", [name for name in ROBOTS if name != "z1"])
def test_built_in_robots_raise_no_doubt(name: str) -> None:
    assert grave(load(name), Scene.load("paper")) == []


def test_links_that_are_seen_and_cannot_be_touched() -> None:
    (text,) = grave(load("z1"), Scene.load("empty"))
    assert "no collision geometry on link01, link05" in text


def test_a_robot_that_nothing_can_touch_is_refused(urdf_file: Callable[..., str]) -> None:
    path = urdf_file(link_xml("a") + link_xml("b") + joint_xml("j", "a", "b"))
    with pytest.raises(RobotError, match="no collision geometry at all"):
        open_world(WorldRequest(path, "empty"))
    with pytest.raises(RobotError, match="no collision geometry at all"):
        make_query(RoadmapRequest.from_options(robot=path, scene="empty", start="q:0", goal="q:1").what)


@pytest.mark.parametrize(
    ("mesh", "parts"),
    [
        (box(0.3), []),
        (box(300.0), ["thing0 would reach 303 m far, and the arm is 0.9 m long: if their numbers are in mill"]),
        (box(1e-5), ["take its 'scale' away"]),
        (OPEN, ["is not closed"]),
        (Mesh(1000 * OPEN.vertices, OPEN.triangles), ["is not closed", "scale meshes by 0.001"]),
    ],
    ids=["sound", "millimetres", "metres scaled down", "open", "both"],
)
def test_meshes_of_a_scene(mesh: Mesh, parts: list[str]) -> None:
    found = grave(load("planar_2r"), scene_of((mesh, pose([0, 0, 3.0]))))
    assert len(found) == len(parts)
    for text, part in zip(found, parts, strict=True):
        assert part in text
        assert "thing0" in text


SHAPES = {
    "box": {"size": [0.4, 0.3, 0.05]},
    "sphere": {"radius": 0.03},
    "cylinder": {"radius": 0.03, "length": 0.6},
    "capsule": {"radius": 0.03, "length": 0.6},
}


def scene_file(folder: Path, kind: str, unit: float, base: float = 0.0) -> Scene:
    """A shape beside a Panda at x = ``base``, one in its hand and one that passes by, in ``unit`` per metre."""
    shape = {"type": kind} | {key: (unit * np.array(value)).tolist() for key, value in SHAPES[kind].items()}
    at = [base + unit * 0.4, unit * -0.2, unit * 0.3]
    held = {"name": "held", "link": "panda_hand", "position": [0.0, 0.0, unit * 0.1], **shape}
    way = [{"t": 0.0, "position": at}, {"t": 1.0, "position": at}]
    obstacles = [{"name": "still", "position": at, **shape}, {"name": "passing", "motion": way, **shape}]
    base_of = {"panda": {"base": {"position": [base, 0.0, 0.0]}}}
    path = folder / "scene.yaml"
    path.write_text(yaml.safe_dump({"obstacles": obstacles, "carried": [held], "robots": base_of}))
    return Scene.load(path)


def doubted(name: str, scene: Scene) -> list[str]:
    """The notes on units of a robot as it stands in the scene, in millimetres or not."""
    return [text for text in grave(open_world(WorldRequest(name, scene)).robot, scene) if "millimetres" in text]


@pytest.mark.parametrize("kind", SHAPES)
def test_shapes_in_millimetres(kind: str, tmp_path: Path) -> None:
    """The sphere of 30 mm is small even in metres: its place gives it away. A cell far from the origin is no doubt."""
    (text,) = doubted("panda", scene_file(tmp_path, kind, 1000.0))
    assert text.startswith("still, passing, held would reach")
    assert text.endswith("in millimetres, give metres, and scale meshes by 0.001.")
    assert doubted("panda", scene_file(tmp_path, kind, 1.0)) == []
    assert doubted("panda", scene_file(tmp_path, kind, 1.0, base=800.0)) == []


@pytest.mark.parametrize("name", ROBOTS)
def test_no_built_in_scene_is_doubted(name: str) -> None:
    for scene in (*scene_names(), *published_scene_names()):
        assert not [note for note in notes(load(name), Scene.load(scene)) if "millimetres" in note.text]


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


# degrees


def test_degrees_are_asked_about_and_never_widened_for() -> None:
    robot = load("iiwa14")
    with pytest.raises(StateError, match="degrees") as caught:
        check_limits(robot, np.array([0, 90, 0, -45, 0, 30, 0.0]), "start")
    assert "--widen-limits" not in str(caught.value)
    with pytest.raises(StateError, match=r"bring it inside, or widen them with --widen-limits\.$"):
        make_query(RoadmapRequest.from_options(start="q:0,2.5,0,-1,0,1,0").what)
    request = RoadmapRequest.from_options(start="q:0,90,0,-45,0,30,0", widen_limits=True)
    with pytest.raises(StateError, match="degrees"):
        make_query(request.what)
