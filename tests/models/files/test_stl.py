"""Binary STL files against the library that reads all kinds of meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planner.models.files.meshes import binary_stl, read_mesh
from planner.models.shapes import Mesh


def stl_of(corners: np.ndarray) -> bytes:
    """A binary STL file of triangles (m, 3, 3)."""
    records = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])
    records["corners"] = corners
    return b"\0" * 80 + len(corners).to_bytes(4, "little") + records.tobytes()


def test_the_same_triangles_as_the_library_reads(tmp_path: Path) -> None:
    corners = np.random.default_rng(0).uniform(-1, 1, size=(50, 3, 3))
    (tmp_path / "a.stl").write_bytes(stl_of(corners))
    found, mesh = binary_stl((tmp_path / "a.stl").read_bytes()), read_mesh(tmp_path / "a.stl")
    assert found is not None
    assert isinstance(mesh, Mesh)
    ours, theirs = (sorted(map(tuple, each.reshape(-1, 9).tolist())) for each in (found, mesh.vertices[mesh.triangles]))
    np.testing.assert_allclose(np.sort(ours, axis=None), np.sort(theirs, axis=None), atol=1e-7)
    np.testing.assert_allclose(found, corners, atol=1e-7)


@pytest.mark.parametrize("content", [b"", b"solid x\nendsolid x\n", b"\0" * 84, stl_of(np.ones((3, 3, 3)))[:-1]])
def test_other_files_are_none(content: bytes) -> None:
    assert binary_stl(content) is None
