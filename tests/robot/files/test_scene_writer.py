"""A scene that is written is the scene that is read."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.base.resources import scene_names
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.scene import Scene, write_scene
from planner.robot.shapes import Carried, Mesh, Obstacle, Sphere
from tests.random_shapes import QUICK, poses, shapes

TURNED = pose([0.1, -0.2, 0.3], rpy=[0.4, -1.1, 2.9])
LETTERS = st.characters(exclude_categories=["Cs"])  # surrogates are no text of a file
NAMES = st.text(LETTERS, min_size=1, max_size=9) | st.sampled_from(
    ["1e-3", "010", "1:30", "yes", "~", "\U0001f600\x85"]
)
HELD = st.builds(Carried, NAMES, st.none(), shapes, poses, st.lists(NAMES, max_size=2).map(tuple))
STANDING = st.builds(Obstacle, st.none(), shapes, poses, speed_limit=st.floats(0, 9))
TIMES = st.lists(st.floats(1e-3, 9), max_size=3).map(lambda steps: np.cumsum([0.0, *steps]))
MOTIONS = TIMES.flatmap(lambda times: st.builds(KnownMotion, st.just(times), st.tuples(*[poses] * len(times))))
THINGS = st.one_of(STANDING, HELD, st.builds(MovingObstacle, st.none(), shapes, MOTIONS))


def triangles(shape: Mesh) -> np.ndarray:
    return shape.vertices[shape.triangles]  # the reader of meshes renumbers vertices


def require_same(first: Scene, second: Scene) -> None:
    for kind in ("obstacles", "moving", "carried"):
        for a, b in zip(getattr(first, kind), getattr(second, kind), strict=True):
            require_same_thing(vars(a), vars(b))
    for key in ("name", "states", "robots", "description", "constraints", "allowed"):
        assert getattr(first, key) == getattr(second, key)


def require_same_thing(a: dict, b: dict) -> None:
    assert a.keys() == b.keys()
    for key, value in a.items():
        match value:
            case Mesh():
                np.testing.assert_array_equal(triangles(value), triangles(b[key]))
            case KnownMotion():
                np.testing.assert_array_equal(value.times, b[key].times)
                np.testing.assert_allclose(value.poses, b[key].poses, atol=1e-14)
            case np.ndarray():
                np.testing.assert_allclose(value, b[key], atol=1e-14)
            case _:
                assert value == b[key]


@QUICK
@given(st.lists(THINGS, max_size=5), st.lists(NAMES, min_size=6, max_size=6, unique=True), st.data())
def test_every_shape_that_stands_moves_or_is_carried(things: list, names: list[str], data: st.DataObject) -> None:
    named = [replace(thing, name=name) for thing, name in zip(things, names, strict=False)]
    pairs = data.draw(st.sets(st.frozensets(st.sampled_from(names), min_size=1, max_size=2), max_size=3))
    kinds: dict[str, Any] = {"obstacles": Obstacle, "moving": MovingObstacle, "carried": Carried}
    by_kind: dict[str, Any] = {key: [one for one in named if isinstance(one, kind)] for key, kind in kinds.items()}
    scene = Scene(
        names[-1],
        description=names[-2],
        states={names[0]: {names[1]: names[2]}},
        allowed=frozenset(pairs),
        constraints="axis:z,0,0,-1,0.0873;turn:0.1",
        **by_kind,
    )
    with TemporaryDirectory() as folder:
        write_scene(scene, Path(folder) / "made.yaml")
        require_same(scene, Scene.load(Path(folder) / "made.yaml"))


@pytest.mark.parametrize("name", scene_names())
def test_the_built_in_scenes(name: str, tmp_path: Path) -> None:
    scene = Scene.load(name)
    assert write_scene(scene, tmp_path / "new" / "copy.yaml") == [tmp_path / "new" / "copy.yaml"]
    require_same(scene, Scene.load(str(tmp_path / "new" / "copy.yaml")))


def test_a_permission_of_something_in_several_shapes(tmp_path: Path) -> None:
    held = tuple(Carried("flange", f"pair.{k}", Sphere(0.1), TURNED, object_id="pair") for k in range(2))
    scene = Scene(
        "made", (Obstacle("box", Sphere(0.1), TURNED),), carried=held, allowed=frozenset({frozenset(("pair", "box"))})
    )
    write_scene(scene, tmp_path / "made.yaml")
    assert Scene.load(str(tmp_path / "made.yaml")).allowed == {frozenset((f"pair.{k}", "box")) for k in range(2)}
