"""Objects of a message become obstacles, or are refused by their name."""

from __future__ import annotations

import time

import numpy as np
import pytest

from planner.base.errors import SceneError
from planner.models.files.moveit.objects import require_once
from planner.models.files.moveit.scenes import planning_scene
from planner.models.shapes import Box, Cylinder, Mesh, Sphere
from tests.models.files.moveit.samples import BOX, HERE, scene


def test_a_box_with_its_pose() -> None:
    (crate,) = planning_scene(scene(BOX), HERE).obstacles
    assert crate.name == crate.object == "crate"
    assert crate.shape == Box((0.1, 0.2, 0.3))
    np.testing.assert_allclose(crate.placement[:3, 3], [1, 2, 3])
    np.testing.assert_allclose(crate.placement[:3, 0], [0, 1, 0], atol=1e-12)


def test_height_comes_before_radius_and_types_may_be_numbers() -> None:
    shapes = [{"type": 3, "dimensions": [0.14, 0.03]}, {"type": "sphere", "dimensions": [0.2]}]
    places = [{}, {"position": {"x": 1, "y": 0, "z": 0}}]
    can = {"id": "can", "primitives": shapes, "primitive_poses": places, "pose": {"position": [0, 0, 1]}}
    first, second = planning_scene(scene(can), HERE).obstacles
    assert (first.name, second.name, first.object, second.object) == ("can.0", "can.1", "can", "can")
    assert (first.shape, second.shape) == (Cylinder(0.03, 0.14), Sphere(0.2))
    np.testing.assert_allclose(second.placement[:3, 3], [1, 0, 1])


def test_a_mesh_in_the_message() -> None:
    sheet = {"id": "sheet", "mesh_poses": [{}], "meshes": [
        {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [{"vertex_indices": [0, 1, 2]}]}]}  # fmt: skip
    (found,) = planning_scene(scene(sheet), HERE).obstacles
    assert isinstance(found.shape, Mesh)
    assert found.shape.triangles.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("bad", "part"),
    [
        ({"primitives": [{"type": "cone", "dimensions": [1, 1]}]}, "'cone' with 2 dimensions is not supported"),
        ({"primitives": [{"type": "box", "dimensions": [1, 1]}]}, "'box' with 2 dimensions"),
        ({"primitives": [{"type": "box", "dimensions": [1, 0, 1]}]}, "dimensions.1' is wrong: Input should be greater"),
        ({"primitive_poses": []}, "1 shapes and 0 poses"),
        ({"primitive_poses": [{"position": [0, float("nan"), 0]}]}, "position"),
        ({"meshes": [{"vertices": [], "triangles": [{"vertex_indices": [0, 1, 2]}]}], "mesh_poses": [{}]}, "vertices"),
    ],
)
def test_refused_objects(bad: dict, part: str) -> None:
    with pytest.raises(SceneError, match=r"test\.yaml") as caught:
        planning_scene(scene({**BOX, **bad}), HERE)
    assert part in str(caught.value)


def test_many_names_are_told_apart_at_once() -> None:
    begin = time.process_time()
    require_once([str(k) for k in range(50_000)], "it")
    assert time.process_time() - begin < 1.0
    with pytest.raises(SceneError, match="'7' is given twice"):
        require_once([*map(str, range(50_000)), "7"], "it")
