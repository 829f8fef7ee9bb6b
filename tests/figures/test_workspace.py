"""Tool paths among obstacles."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Path3DCollection

from planner import figures
from planner.figures.workspace import clip_face, faces_of
from planner.kinematics.forward import tool_positions
from planner.planning.result import Plan
from planner.robot.poses import pose
from planner.robot.shapes import Box, Capsule, Cylinder, Shape, Sphere
from planner.trajectory.measure import dense_path
from tests.random_shapes import box_mesh


def test_tool_paths_pass_where_the_tool_passes(solved: Plan) -> None:
    half = solved.path[: len(solved.path) // 2 + 1]
    figure = figures.tool_paths({"whole": solved, "half": half}, checker=solved.checker)
    shown: Any = figure.axes[0]
    assert [shown.get_xlabel(), shown.get_ylabel(), shown.get_zlabel()] == ["x (m)", "y (m)", "z (m)"]
    found = {line.get_label(): np.array(line.get_data_3d()).T for line in shown.get_lines()}
    assert np.array_equal(found["half"], tool_positions(solved.robot, dense_path(half)))
    assert shown.get_zlim()[0] <= found["whole"][:, 2].min()
    assert {text.get_text().strip() for text in shown.texts} == {"start", "goal"}
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["whole", "half"]


def test_a_path_is_as_light_as_its_w_is_high(solved: Plan) -> None:
    axes, bar = figures.tool_paths(solved, shade="w").axes
    shaded: Any = next(part for part in axes.collections if isinstance(part, Line3DCollection))
    assert np.array_equal(shaded.get_array(), solved.w_along_path[1][1:])
    assert shaded.get_clim() == (0.0, solved.w_along_path[1].max())
    assert "(m³)" in bar.get_ylabel()


def test_the_roadmap_lies_where_the_tool_goes(solved: Plan) -> None:
    figure = figures.roadmap(solved)
    axes: Any = figure.axes[0]
    roadmap, robot = solved.roadmap, solved.robot
    dots: Any = next(part for part in axes.collections if isinstance(part, Path3DCollection))
    assert np.array_equal(np.ma.getdata(dots.get_array()), roadmap.manipulability)
    x, y, z = dots._offsets3d
    assert np.allclose(np.stack([x, y, z], axis=1), tool_positions(robot, roadmap.nodes))
    edges: Any = next(part for part in axes.collections if isinstance(part, Line3DCollection))
    drawn = np.array(edges._segments3d)
    a, b = roadmap.nodes[roadmap.edges.T]
    assert len(drawn) == len(roadmap.edges)
    assert np.allclose(drawn[:, 2], tool_positions(robot, a + 0.5 * robot.difference(a, b)))
    path = np.array(axes.get_lines()[1].get_data_3d()).T
    assert np.array_equal(path, tool_positions(robot, dense_path(solved.path)))


@pytest.mark.parametrize(
    ("shape", "half"),
    [
        (Box((0.2, 0.4, 0.6)), (0.1, 0.2, 0.3)),
        (Sphere(0.3), (0.3, 0.3, 0.3)),
        (Cylinder(0.1, 0.8), (0.1, 0.1, 0.4)),
        (Capsule(0.1, 0.8), (0.1, 0.1, 0.5)),
        (box_mesh((0.2, 0.4, 0.6)), (0.1, 0.2, 0.3)),
    ],
    ids=["box", "sphere", "cylinder", "capsule", "mesh"],
)
def test_faces_reach_as_far_as_the_shape_and_are_flat(shape: Shape, half: tuple[float, ...]) -> None:
    placement = pose((1.0, 2.0, 3.0), rpy=(0.0, 0.0, np.pi / 2))
    faces = faces_of(shape, placement)
    corners = np.concatenate(faces) - [1.0, 2.0, 3.0]
    turned = np.array([half[1], half[0], half[2]])
    assert np.abs(corners).max(axis=0) == pytest.approx(turned, rel=0.01)
    for face in faces:
        across = np.linalg.svd(face - face.mean(axis=0), compute_uv=False)
        assert len(across) < 3 or across[-1] < 1e-12


def test_a_face_is_cut_at_the_box() -> None:
    rng = np.random.default_rng(0)
    low, high = np.full(3, -0.5), np.full(3, 0.5)
    for _ in range(50):
        face = rng.uniform(-1.5, 1.5, (3, 3))
        cut = clip_face(face, low, high)
        share = rng.dirichlet(np.ones(3), 4000) @ face
        inside = ((share >= low) & (share <= high)).all(axis=1).mean()
        area = sum(np.linalg.norm(np.cross(b - cut[0], c - cut[0])) for b, c in itertools.pairwise(cut[1:]))
        assert area / np.linalg.norm(np.cross(face[1] - face[0], face[2] - face[0])) == pytest.approx(inside, abs=0.04)
        if len(cut):
            assert (cut >= low - 1e-12).all()
            assert (cut <= high + 1e-12).all()
    assert len(clip_face(np.full((3, 3), 2.0), low, high)) == 0
