"""A scene that is written is the scene that is read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import SceneError
from planner.base.resources import scene_names
from planner.models.files.scene_writer import write_scene
from planner.models.moving import KnownMotion, MovingObstacle
from planner.models.poses import pose
from planner.models.scene import Scene
from planner.models.shapes import Box, Capsule, Carried, Cylinder, Mesh, Obstacle, Sphere

TURNED = pose([0.1, -0.2, 0.3], rpy=[0.4, -1.1, 2.9])
CORNERS = np.array([[0.0, 0.0, 0.0], [0.25, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.125]])
TETRAHEDRON = Mesh(CORNERS, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))


def require_same(first: Scene, second: Scene) -> None:
    assert [item.name for item in first.obstacles] == [item.name for item in second.obstacles]
    pairs = [*zip(first.obstacles, second.obstacles, strict=True), *zip(first.carried, second.carried, strict=True)]
    for a, b in pairs:
        if isinstance(a.shape, Mesh):  # its reader numbers vertices anew
            assert isinstance(b.shape, Mesh)
            np.testing.assert_array_equal(a.shape.vertices[a.shape.triangles], b.shape.vertices[b.shape.triangles])
        else:
            assert a.shape == b.shape
        np.testing.assert_allclose(a.placement, b.placement, atol=1e-15)
    assert first.states == second.states
    assert first.robots == second.robots
    assert first.description == second.description
    assert first.keep == second.keep


@pytest.mark.parametrize("name", scene_names())
def test_the_built_in_scenes(name: str, tmp_path: Path) -> None:
    scene = Scene.load(name)
    assert write_scene(scene, tmp_path / "new" / "copy.yaml") == [tmp_path / "new" / "copy.yaml"]
    require_same(scene, Scene.load(str(tmp_path / "new" / "copy.yaml")))


def test_what_moves(tmp_path: Path) -> None:
    motion = KnownMotion([0.0, 1.5, 4.0], [TURNED, pose([1.0, 0.0, 0.25]), pose([1.0, 2.0, 0.25])])
    moving = (MovingObstacle("cart", Box((0.1, 0.2, 0.3)), motion),)
    scene = Scene("made", (Obstacle("dog", Sphere(0.1), TURNED, speed_limit=0.5),), moving=moving)
    write_scene(scene, tmp_path / "made.yaml")
    again = Scene.load(str(tmp_path / "made.yaml"))
    require_same(scene, again)
    assert again.obstacles[0].speed_limit == 0.5
    (cart,) = again.moving
    assert (cart.name, cart.shape) == ("cart", moving[0].shape)
    np.testing.assert_array_equal(cart.motion.times, motion.times)
    np.testing.assert_allclose(cart.motion.poses, motion.poses, atol=1e-15)


def test_every_shape_what_is_carried_and_what_may_touch(tmp_path: Path) -> None:
    shapes = (Box((0.1, 0.2, 0.3)), Sphere(0.1), Cylinder(0.1, 0.2), Capsule(0.05, 0.3), TETRAHEDRON)
    obstacles = tuple(Obstacle(f'it\'s "{k}" é', shape, TURNED) for k, shape in enumerate(shapes))
    obstacles += tuple(Obstacle(f"part {k}", Sphere(0.02), TURNED, part_of="whole") for k in range(2))
    held = (Carried("flange", "plate", TETRAHEDRON, TURNED, ("iiwa14_link_7",)),)
    allowed = frozenset({frozenset(("whole", "iiwa14_link_7")), frozenset((obstacles[0].name, "iiwa14_link_1"))})
    scene = Scene("made", obstacles, states={"iiwa14": {"start": "q:0,0,0,0,0,0,0"}}, carried=held, allowed=allowed)
    written = write_scene(scene, tmp_path / "made.yaml")
    assert [path.name for path in written] == ["made.yaml", "made-0.obj", "made-1.obj"]
    again = Scene.load(str(tmp_path / "made.yaml"))
    require_same(scene, again)
    assert again.carried[0].touch_links == ("iiwa14_link_7",)
    links = {(item.object, link) for item in again.obstacles for link in ("iiwa14_link_1", "iiwa14_link_7")}
    assert {pair for pair in links if frozenset(pair) in again.allowed} == {
        (obstacles[0].name, "iiwa14_link_1"),
        ("part 0", "iiwa14_link_7"),
        ("part 1", "iiwa14_link_7"),
    }


def test_what_is_kept(tmp_path: Path) -> None:
    scene = Scene("made", keep="axis:z,0,0,-1,0.0873;turn:0.1")
    write_scene(scene, tmp_path / "made.yaml")
    require_same(scene, Scene.load(str(tmp_path / "made.yaml")))


def test_a_permission_of_something_carried_in_several_shapes(tmp_path: Path) -> None:
    held = tuple(Carried("flange", f"pair.{k}", Sphere(0.1), TURNED, part_of="pair") for k in range(2))
    scene = Scene(
        "made", (Obstacle("box", Sphere(0.1), TURNED),), carried=held, allowed=frozenset({frozenset(("pair", "box"))})
    )
    write_scene(scene, tmp_path / "made.yaml")
    assert Scene.load(str(tmp_path / "made.yaml")).allowed == {frozenset((f"pair.{k}", "box")) for k in range(2)}


@pytest.mark.parametrize(
    ("item", "said"),
    [
        (Obstacle("box", Sphere(0.1), TURNED, frame="cell"), "'box' is placed in frame 'cell'"),
        (Obstacle("part", replace(TETRAHEDRON, radius=0.01), TURNED), "the mesh of 'part' has a radius"),
    ],
)
def test_what_no_scene_file_says_is_refused(item: Obstacle, said: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=said):
        write_scene(Scene("made", (item,)), tmp_path / "made.yaml")
    assert not any(tmp_path.iterdir())


def test_names_of_any_letters(tmp_path: Path) -> None:
    """Letters beyond the first 65,536 were written as JSON has them, which is no YAML: the file could not be read."""
    name = "ball \U0001f600 \\ud83d\\ude00 é\x85"
    scene = Scene(name, (Obstacle(name, Sphere(0.1), pose([1.0, 0.0, 0.0])),))
    write_scene(scene, tmp_path / "scene.yaml")
    there = Scene.load(tmp_path / "scene.yaml")
    assert (there.name, there.obstacles[0].name) == (name, name)
