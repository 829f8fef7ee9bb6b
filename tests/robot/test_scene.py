"""Scene files: what each key means, what is refused and with which words."""

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from planner.base.errors import FileError, SceneError
from planner.problem.targets import Named, parse_target
from planner.robot.files.urdf import frame_id
from planner.robot.poses import pose
from planner.robot.robot import Robot, with_carried
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Obstacle, Sphere
from planner.robot.solids import is_watertight
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


def test_set_up_of_a_robot(scene):
    made = scene(
        """
        robots:
          iiwa14: {base: {position: [0, 0, 0.5], rpy: [0, 0, 1.0]}, tool: iiwa14_link_7, fixed_joints: {j: 0.5}}
        states: {iiwa14: {start: "q:0"}}
        """
    )
    placement = made.placement("iiwa14")
    np.testing.assert_allclose(placement.base.matrix(), pose([0, 0, 0.5], rpy=[0, 0, 1.0]))
    assert placement.tool == "iiwa14_link_7"
    assert placement.fixed_joints == {"j": 0.5}
    other = made.placement("panda")
    assert (other.tool, other.fixed_joints) == (None, {})
    np.testing.assert_array_equal(other.base.matrix(), np.eye(4))
    assert made.states_of("iiwa14") == {"start": "q:0"}
    assert made.states_of("panda") == {}


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


def item(body: str) -> str:
    return f"obstacles: [{{name: a, {body}}}]"


REFUSED = {
    "unknown key": (item("type: sphere, radius: 1, colour: red"), ["unknown key 'obstacles.0.sphere.colour'"]),
    "missing type": (item("radius: 1"), ["obstacles.0", "type"]),
    "unknown type": (item("type: cone, radius: 1"), ["type 'cone'", "'box', 'sphere', 'cylinder', 'capsule', 'mesh'"]),
    "zero-size box": (item("type: box, size: [1, 0, 1]"), ["size.1", "greater than or equal to 0.000001", "(got 0)"]),
    "NaN": (item("type: sphere, radius: .nan"), ["radius", "(got nan)"]),
    "two rotations": (
        item("type: sphere, radius: 1, rpy: [0, 0, 0], quaternion: [0, 0, 0, 1]"),
        ["give rpy or quaternion, not both"],
    ),
    "name twice": (
        "obstacles: [{name: a, type: sphere, radius: 1}, {name: a, type: sphere, radius: 2}]",
        ["'a' is used twice", "names must differ"],
    ),
    "a list": ("- 1\n- 2", ["holds no mapping of keys to values", "obstacles"]),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(scene, case):
    text, parts = REFUSED[case]
    with pytest.raises(SceneError) as caught:
        scene(text)
    message = str(caught.value)
    assert [part for part in ["scene file", "made.yaml", *parts] if part not in message] == []
    assert "\n" not in message
    assert message.endswith(".")
    assert caught.value.exit_code == 3


@pytest.mark.parametrize("name", SCENES)
def test_every_set_up_fits_its_robot(name):
    scene = Scene.load(name)
    for robot in {*scene.robots, *scene.states}:
        placement = scene.placement(robot)
        made = Robot.load(robot, placement.tool, placement.fixed_joints, placement.base.matrix())
        assert made.name == robot


CARRIED = """
obstacles: [{name: box, type: box, size: [0.1, 0.1, 0.1], position: [1, 1, 1]}]
carried:
  - {name: rod, type: capsule, radius: 0.01, length: 0.2, position: [0, 0, 0.1], link: link_2, touch_links: [link_1]}
"""


def test_what_is_carried_becomes_a_body_of_the_link_that_holds_it(scene):
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


def test_dicts_are_what_a_file_says(scene, tmp_path, monkeypatch):
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


@pytest.mark.parametrize(
    ("wrong", "error", "words"),
    [
        ([{"type": "box"}], SceneError, "'obstacles.0.box.size' is missing"),
        ([{"type": "sphere", "radius": 0.1, "positon": [0, 0, 1]}], SceneError, "did you mean 'position'"),
        ([{"type": "mesh", "file": "nowhere.stl"}], FileError, "nowhere.stl not found"),
        ([5], TypeError, "obstacles must be planner.Obstacle, MovingObstacle or dicts, got int"),
    ],
)
def test_wrong_dicts_are_refused(wrong, error, words):
    with pytest.raises(error, match=words):
        Scene(obstacles=wrong)


def test_none_is_the_empty_scene():
    assert Scene.load(None).name == "empty"
    made = Scene.load("paper")
    assert Scene.load(made) is made


@pytest.mark.parametrize("process", [True, False])
def test_a_trimesh_is_what_its_file_is(process, scene, tmp_path):
    """Whether trimesh has joined the vertices or not."""
    ring, place = trimesh.creation.annulus(0.1, 0.2, 0.3), pin.SE3.Random()
    ring.export(tmp_path / "ring.stl")
    read = scene("obstacles: [{name: ring, type: mesh, file: ring.stl}]").obstacles[0]
    loaded: Any = trimesh.load_mesh(tmp_path / "ring.stl", process=process)
    made = Obstacle("ring", loaded, place)
    assert isinstance(made.shape, Mesh)
    np.testing.assert_array_equal(made.shape.vertices, read.shape.vertices)
    np.testing.assert_array_equal(made.shape.triangles, read.shape.triangles)
    np.testing.assert_array_equal(made.placement, place.homogeneous)
    assert is_watertight(made.shape)


def test_primitives_of_trimesh_are_meshes():
    box: Any = trimesh.primitives.Box((0.1, 0.2, 0.3))
    mesh = Obstacle("box", box, np.eye(4)).shape
    assert isinstance(mesh, Mesh)
    assert is_watertight(mesh)
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [0.1, 0.2, 0.3])
    with pytest.raises(TypeError, match=r"a trimesh.Trimesh, got Scene"):
        Obstacle("scene", box.scene(), np.eye(4))
