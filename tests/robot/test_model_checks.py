"""Models that load and make little sense are noticed, with a remedy."""

import pytest

from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.robot_in_scene import notes
from planner.robot.scene import Scene
from planner.robot.shapes import Mesh
from tests.robot.test_solids import box
from tests.worlds import ROBOTS, load, scene_of

OPEN = Mesh(box(0.3).vertices, box(0.3).triangles[1:])


def grave(robot: Robot, scene: Scene) -> list[str]:
    return [note.text for note in notes(robot, scene) if note.grave]


@pytest.mark.parametrize("name", [name for name in ROBOTS if name != "z1"])
def test_built_in_robots_raise_no_doubt(name: str) -> None:
    assert grave(load(name), Scene.load("paper")) == []


@pytest.mark.parametrize(
    ("mesh", "parts"),
    [
        (box(0.3), []),
        (box(300.0), ["thing0 would reach 303 m far, and the arm is 0.9 m long: if their numbers are in mill"]),
        (OPEN, ["is not closed"]),
        (Mesh(1000 * OPEN.vertices, OPEN.triangles), ["is not closed", "scale meshes by 0.001"]),
    ],
    ids=["sound", "millimetres", "open", "both"],
)
def test_meshes_of_a_scene(mesh: Mesh, parts: list[str]) -> None:
    found = grave(load("planar_2r"), scene_of((mesh, pose([0, 0, 3.0]))))
    assert len(found) == len(parts)
    for text, part in zip(found, parts, strict=True):
        assert part in text
        assert "thing0" in text
