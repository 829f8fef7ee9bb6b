"""Each format holds the same tetrahedron."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.fuzz import mesh_files
from planner.models.files.meshes import read_mesh

FILES = {
    "a.stl": mesh_files.stl,
    "b.stl": mesh_files.stl_text,
    "c.obj": mesh_files.obj,
    "d.ply": mesh_files.ply,
    "e.ply": mesh_files.ply_of_bytes,
    "f.dae": mesh_files.dae,
}


@pytest.mark.parametrize("name", FILES)
def test_a_tetrahedron_is_read_back(name: str, tmp_path: Path) -> None:
    content = FILES[name]()
    (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
    mesh = read_mesh(tmp_path / name)
    assert len(mesh.triangles) == 4
    corners = np.unique(mesh.vertices[mesh.triangles].reshape(-1, 3), axis=0)
    np.testing.assert_allclose(corners, [[0, 0, 0], [0, 0, 1], [0, 1, 0], [1, 0, 0]], atol=1e-6)
