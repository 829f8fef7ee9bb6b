"""Mesh files as shapes: each kind of file gives the mesh that was written, or a refusal."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, KDTree

from planner.base.errors import FileError
from planner.robot.files.meshes import read_mesh, split_into_components
from planner.robot.shapes import Body, Mesh
from planner.robot.solids import solid_of
from tests.random_shapes import QUICK, blob
from tests.refusals import refusal_of

KINDS: dict[str, dict[str, Any]] = {
    "stl": {},
    "ascii.stl": {"file_type": "stl_ascii"},
    "obj": {"digits": 12},
    "ply": {},
    "ascii.ply": {"encoding": "ascii"},
    "dae": {},
    "glb": {},
}


def mesh_file(mesh: Mesh, kind: str = "stl") -> bytes:
    """A file of a ``kind``, written by trimesh."""
    written = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    content: Any = written.export(**{"file_type": kind.rpartition(".")[2], **KINDS[kind]})
    return content.encode() if isinstance(content, str) else content


def read(content: Any, kind: str) -> Mesh:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"a.{kind}")
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return read_mesh(path)


def volume(mesh: Mesh) -> float:
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


@st.composite
def meshes(draw: st.DrawFn) -> Mesh:
    """A convex hull of random points, or a closed surface with dents."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    if draw(st.booleans()):
        return blob(rng, float(rng.uniform(0.1, 2)))
    points = rng.normal(size=(12, 3))
    hull = ConvexHull(points)
    return Mesh(points, hull.simplices.astype(int))


@pytest.mark.parametrize("kind", KINDS)
@given(mesh=meshes())
@QUICK
def test_a_mesh_is_read_as_it_was_written(kind: str, mesh: Mesh) -> None:
    found = read(mesh_file(mesh, kind), kind)
    assert len(found.triangles) == len(mesh.triangles)
    expected = mesh.vertices[np.unique(mesh.triangles)]
    assert len(found.vertices) == len(expected)
    for one, other in ((found.vertices, expected), (expected, found.vertices)):
        assert KDTree(one).query(other)[0].max() < 1e-6
    assert volume(found) == pytest.approx(volume(mesh), rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("kind", KINDS)
@given(mesh=meshes(), share=st.floats(0, 1, exclude_max=True))
@QUICK
def test_a_file_that_is_cut_off_is_whole_or_refused(kind: str, mesh: Mesh, share: float) -> None:
    content = mesh_file(mesh, kind)
    try:
        found = read(content[: int(share * len(content))], kind)
    except FileError:
        return
    if kind != "obj":  # which does not say how many faces it has
        assert len(found.triangles) == len(mesh.triangles)


PLY = (
    "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n4 0 1 2 3\n3 0 1 4\n"
)
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\n"
SOLID = (
    "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid x\n"
)


@pytest.mark.parametrize(
    ("content", "kind", "area"),
    [
        (PLY, "ply", 1.5),
        (OBJ + "f 1 2 3 4\nf 1 2 5\n", "obj", 1.5),
        (
            OBJ + "vn 0 0 1\nmtllib /etc/passwd\nusemtl x\n \tf  1//1 2//1 3//1 4//1 # two\r\nf 1//1 2//1 \\\n5//1\n",
            "obj",
            1.5,
        ),
        (OBJ.replace("v 1 1 0", "v\t1e0  1. -.0 1.0") + "f 1 2 3\n", "obj", 0.5),
        (OBJ.replace("v 1 1 0", "v 1 1 0 .1 .2 .3") + "f 1 2 3\n", "obj", 0.5),
        (OBJ + "v 0.5 2 0\nf 1 2 3 6 4\n", "obj", 1.5),
        (SOLID + SOLID.replace("0 1 0", "0 2 0"), "stl", 1.5),
    ],
)
def test_polygons_spaces_and_several_solids_are_read(content: str, kind: str, area: float) -> None:
    a, b, c = (mesh := read(content, kind)).vertices[mesh.triangles].transpose(1, 0, 2)
    assert 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() == pytest.approx(area)


@pytest.mark.parametrize(
    ("content", "kind"),
    [
        *[(PLY.replace("3 0 1 4", row), "ply") for row in ("3 0 1 9", "3 0 1 x", "3 0 1 -4", "")],
        *[(PLY.replace(*old_new), "ply") for old_new in (("1 0 0\n", ""), ("vertex 5", "vertex 9"), ("ascii", "odd"))],
        *[(PLY.replace("float y", name), "ply") for name in ("float x", "flt y")],
        *[(OBJ + f"f 1 2 3\n{line}\n", "obj") for line in ("f 1 2 9", "f 0 1 2", "f 1 2 -1", "f 1 2", "F 1 2 3")],
        *[(f"{OBJ}{line}\nf 1 2 3\n", "obj") for line in ("v 0,5 1 0", "v 1 0", "v 1 0 x", "v 1 1 1 .5", "surf 0 1")],
        *[(SOLID.replace("0 1 0", corner), "stl") for corner in ("0 1", "0 1 x", "0 1 1D3", "0 1 0 0", "0 nan 0")],
        *[(SOLID + SOLID[:80], "stl"), ("", "stl"), ("solid x\nendsolid x\n", "stl"), ("name: a", "yaml")],
    ],
)
def test_files_that_would_be_misread_are_refused(content: str, kind: str) -> None:
    assert "mesh file" in refusal_of(lambda: read(content, kind))


def joined(*parts: Mesh) -> Mesh:
    """The triangles of all ``parts`` in one mesh."""
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    triangles = [part.triangles + start for part, start in zip(parts, first, strict=False)]
    return Mesh(np.concatenate([part.vertices for part in parts]), np.concatenate(triangles))


def body_of(mesh: Mesh) -> Body:
    return Body("link_0", "link", 1, mesh, np.eye(4))


@QUICK
@given(st.integers(1, 12), st.integers(0, 2**32))
def test_the_pieces_of_a_mesh_have_its_surface_and_its_inside(count: int, seed: int) -> None:
    """Blobs far apart, one of them hollow; which points are inside is known of each blob by itself."""
    rng = np.random.default_rng(seed)
    blobs = [blob(rng, float(rng.uniform(0.1, 0.9))) for _ in range(count)]
    places = [np.array([2.0 * k, 0.0, 0.0]) for k in range(count)]
    moved = [Mesh(one.vertices + at, one.triangles) for one, at in zip(blobs, places, strict=True)]
    hole = Mesh(0.5 * blobs[0].vertices + places[0], blobs[0].triangles[:, ::-1])
    whole = joined(*moved, hole)
    made = split_into_components(body_of(whole))
    assert len(made) == min(count, 8)
    assert len({body.name for body in made}) == len(made)
    corners = np.concatenate(
        [body.shape.vertices[body.shape.triangles] for body in made if isinstance(body.shape, Mesh)]
    )
    own = whole.vertices[whole.triangles]
    np.testing.assert_array_equal(np.unique(corners, axis=0), np.unique(own, axis=0))
    assert len(corners) == len(own)
    points = np.concatenate(places).reshape(-1, 3) + rng.uniform(-0.5, 0.5, size=(40, 1, 3))
    solids = [solid for body in made if isinstance(body.shape, Mesh) and (solid := solid_of(body.shape)) is not None]
    solid = solid_of(whole)
    held = np.any([each.contains(points.reshape(-1, 3)) for each in solids], axis=0)
    np.testing.assert_array_equal(held, solid.contains(points.reshape(-1, 3)))
