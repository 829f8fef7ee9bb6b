"""Scene files: the meaning of each key."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner.base.errors import SceneError
from planner.problem.targets import Named, parse_target
from planner.robot.files.urdf import frame_id
from planner.robot.poses import pose
from planner.robot.robot import Robot, with_carried
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Sphere
from tests.worlds import SCENES

STL = """solid one
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 100 0 0
vertex 0 50 0
endloop
endfacet
endsolid one
"""


@pytest.fixture
def scene(tmp_path):
    def load(text: str, name: str = "made.yaml") -> Scene:
        (tmp_path / name).write_text(text)
        return Scene.load(str(tmp_path / name))

    return load


@pytest.mark.parametrize("name", SCENES)
def test_every_scene(name):
    scene = Scene.load(name)
    assert scene.name == name
    assert scene.description
    assert len({obstacle.name for obstacle in scene.obstacles}) == len(scene.obstacles)
    for states in scene.states.values():
        for text in states.values():
            assert not isinstance(parse_target(text), Named)
    for obstacle in scene.obstacles:
        turn = obstacle.placement[:3, :3]
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)


def test_every_kind_of_obstacle(scene, tmp_path):
    (tmp_path / "one.stl").write_text(STL)
    obstacles = scene(
        """
        obstacles:
          - {name: board, type: box, size: [0.8, 0.3, 0.02], position: [0.5, 0, 0.6]}
          - {name: post, type: cylinder, radius: 0.03, length: 1.0}
          - {name: ball, type: sphere, radius: 0.1}
          - {name: bar, type: capsule, radius: 0.02, length: 0.5}
          - {name: part, type: mesh, file: one.stl, scale: 0.001}
        """
    ).obstacles
    assert [o.name for o in obstacles] == ["board", "post", "ball", "bar", "part"]
    shapes = [o.shape for o in obstacles]
    assert shapes[:4] == [Box((0.8, 0.3, 0.02)), Cylinder(0.03, 1.0), Sphere(0.1), Capsule(0.02, 0.5)]
    assert isinstance(shapes[4], Mesh)
    np.testing.assert_allclose(shapes[4].vertices.max(axis=0), [0.1, 0.05, 0])
    np.testing.assert_allclose(obstacles[0].placement[:3, 3], [0.5, 0, 0.6])
    np.testing.assert_array_equal(obstacles[1].placement, np.eye(4))


# identity

ONE = "obstacles: [{name: a, type: box, size: [1, 2, 3]}, {name: b, type: sphere, radius: 1, position: [1, 0, 0]}]"
SAME = [
    "obstacles: [{name: b, type: sphere, radius: 1, position: [1, 0, 0]}, {name: a, type: box, size: [1, 2, 3]}]",
    "obstacles: [{name: x, type: box, size: [1, 2, 3]}, {name: y, type: sphere, radius: 1, position: [1, 0, 0]}]",
    "name: other\nstates: {iiwa14: {start: 'q:0'}}\n" + ONE,
]
OTHER = [
    ONE.replace("radius: 1", "radius: 1.001"),
    ONE.replace("[1, 0, 0]", "[1, 0, 0.001]"),
    ONE.replace("[1, 2, 3]", "[1, 3, 2]"),
    "obstacles: [{name: a, type: box, size: [1, 2, 3]}]",
    ONE.replace("type: sphere, radius: 1", "type: capsule, length: 1, radius: 1"),
    ONE.replace("size: [1, 2, 3]", "size: [1, 2, 3], rpy: [0, 0, 1.5]"),
]


@pytest.mark.parametrize("text", SAME)
def test_identity_minds_neither_order_nor_names(scene, text):
    assert scene(text).identity == scene(ONE).identity


@pytest.mark.parametrize("text", OTHER)
def test_identity_minds_shapes_and_places(scene, text):
    assert scene(text).identity != scene(ONE).identity


# refusals


CARRIED = """
obstacles: [{name: box, type: box, size: [0.1, 0.1, 0.1], position: [1, 1, 1]}]
carried:
  - {name: rod, type: capsule, radius: 0.01, length: 0.2, position: [0, 0, 0.1], link: link_2, touch_links: [link_1]}
"""


def test_a_carried_object_becomes_a_body_of_the_link_that_holds_it(scene):
    made = scene(CARRIED)
    robot = with_carried(Robot.load("planar_2r"), made.carried)
    (rod,) = robot.carried
    held = robot.model.frames[frame_id(robot.model, "link_2")]
    assert (rod.name, rod.shape, rod.joint) == ("rod", Capsule(0.01, 0.2), held.parentJoint)
    np.testing.assert_allclose(rod.placement, held.placement.homogeneous @ pose([0, 0, 0.1]))
    assert robot.touching == {frozenset(("rod", "link_2")), frozenset(("rod", "link_1"))}


DICTS: Any = [
    {"type": "box", "size": np.array([0.8, 0.3, 0.02]), "position": (0.5, 0, 0.6)},
    {"name": "post", "type": "cylinder", "radius": 0.03, "length": 1.0, "rpy": [0, 1.5, 0], "speed_limit": 0.2},
    {"name": "part", "type": "mesh", "file": Path("one.stl"), "scale": 0.001},
    {"name": "cart", "type": "sphere", "radius": 0.1, "motion": [{"t": 0}, {"t": 2, "position": [1, 0, 0]}]},
]
YAML = """
obstacles:
  - {name: box_0, type: box, size: [0.8, 0.3, 0.02], position: [0.5, 0, 0.6]}
  - {name: post, type: cylinder, radius: 0.03, length: 1.0, rpy: [0, 1.5, 0], speed_limit: 0.2}
  - {name: part, type: mesh, file: one.stl, scale: 0.001}
  - {name: cart, type: sphere, radius: 0.1, motion: [{t: 0}, {t: 2, position: [1, 0, 0]}]}
"""


def test_dicts_are_read_as_a_file_is(scene, tmp_path, monkeypatch):
    (tmp_path / "one.stl").write_text(STL)
    monkeypatch.chdir(tmp_path)
    read, made = scene(YAML), Scene(obstacles=DICTS)
    assert made.identity == read.identity
    for a, b in zip((*made.obstacles, *made.moving), (*read.obstacles, *read.moving), strict=True):
        assert (a.name, a.shape.content()[0]) == (b.name, b.shape.content()[0])
    assert [each.speed_limit for each in made.obstacles] == [0.0, 0.2, 0.0]
    np.testing.assert_array_equal(made.moving[0].motion.poses, read.moving[0].motion.poses)
    with pytest.raises(SceneError, match="has 'post' twice"):
        Scene("x", (*read.obstacles, DICTS[1]))
