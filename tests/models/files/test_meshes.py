"""Mesh files as shapes."""

from __future__ import annotations

from pathlib import Path

import coal
import numpy as np
import pytest

from planner.base.errors import FileError
from planner.models.files.meshes import fault, read_mesh, shape_of
from planner.models.shapes import Box, Capsule, Cylinder, Mesh, Sphere
from tests.coal_judge import coal_geometry
from tests.refusals import refusal_of


@pytest.mark.parametrize("corner", ["nan 0 0", "1e30 0 0", "inf 0 0"])
def test_vertices_out_of_range(corner: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    facet = f"facet normal 0 0 1\nouter loop\nvertex {corner}\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    (tmp_path / "a.stl").write_text(f"solid x\n{facet}{facet}endsolid x\n")
    refusal_of(lambda: read_mesh(tmp_path / "a.stl"))
    assert capfd.readouterr() == ("", ""), "the libraries' own text"


TRIANGLE = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))


def test_geometries_of_coal_are_our_shapes() -> None:
    for shape in (Box((0.1, 0.2, 0.3)), Sphere(0.1), Capsule(0.1, 0.4), Cylinder(0.2, 0.3)):
        assert shape_of(coal_geometry(shape)) == shape
    with pytest.raises(ValueError, match="Cone is not supported"):
        shape_of(coal.Cone(0.1, 0.2))


@pytest.mark.parametrize(
    ("vertices", "triangles", "words"),
    [
        (TRIANGLE.vertices, np.zeros((0, 3), dtype=int), "no usable triangles"),
        (np.nan * TRIANGLE.vertices, TRIANGLE.triangles, "no usable triangles"),
        (TRIANGLE.vertices, np.array([[0, 1, 3]]), "not there"),
        (1e5 * TRIANGLE.vertices, TRIANGLE.triangles, "100000 m far"),
        (1e-8 * TRIANGLE.vertices, TRIANGLE.triangles, "smaller than a micrometre"),
    ],
)
def test_unusable_meshes_are_told_apart(vertices: np.ndarray, triangles: np.ndarray, words: str) -> None:
    assert fault(TRIANGLE.vertices, TRIANGLE.triangles) is None
    assert words in (fault(vertices, triangles) or "")


@pytest.mark.parametrize(
    "line",
    ["v 1 .5 0", "v 0,5 1 0", "v 1 0", "v 1 0 x", "v 1 0 0 1 1", " v 1 0 0", "\tf 1 2 4", f"v {'1' * 100000}x 0"],
)
def test_lines_that_assimp_skips_or_cuts_off(line: str, tmp_path: Path) -> None:
    """Vertices behind a skipped one would get the numbers of others, and faces other corners."""
    (tmp_path / "m.obj").write_text(f"v 0 0 0\nv 1 0 0\n{line}\nv 0 1 0\nv 0 0 1\nf 1 2 3\n")
    with pytest.raises(FileError, match=r"has a line '[vf] .* that is skipped: export it again"):
        read_mesh(tmp_path / "m.obj")


def test_vertices_as_exporters_write_them(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\r\nv\t1e0  -0. +0.0 # a\nv 0 1 0 0.5 0.5 0.5 \nvn 0 0 1\nf 1 2 3\n")
    assert read_mesh(tmp_path / "m.obj").vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
