"""Mesh files as shapes."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.world.meshes import read_mesh
from tests.refusals import refusal_of


@pytest.mark.parametrize("corner", ["nan 0 0", "1e30 0 0", "inf 0 0"])
def test_vertices_out_of_range(corner: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    facet = f"facet normal 0 0 1\nouter loop\nvertex {corner}\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    (tmp_path / "a.stl").write_text(f"solid x\n{facet}{facet}endsolid x\n")
    refusal_of(lambda: read_mesh(tmp_path / "a.stl"))
    assert capfd.readouterr() == ("", ""), "the libraries' own text"
