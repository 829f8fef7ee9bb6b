"""PLY files: sound ones are read, what their reader would not survive is refused first."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.models.files.meshes import read_mesh
from planner.models.files.ply import ply_fault
from tests.refusals import refusal_of

PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
)


def test_a_sound_ply_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.ply").write_text(PLY)
    assert len(read_mesh(tmp_path / "a.ply").triangles) == 1


@pytest.mark.parametrize(
    "bad",
    [
        PLY.replace("3 0 1 2", "3 0 1 99999999"),  # each of these crashed or filled the memory
        PLY.replace("3 0 1 2", "~ 0 1 2"),
        PLY.replace("3 0 1 2", "999999999 0 1 2"),
        PLY.replace("vertex 3", "vertex 999999999"),
        PLY.replace("1 0 0\n", ""),
        PLY.replace("property float y", "property float x"),
        PLY.replace("property float z", "property float z\nproperty float w"),
        PLY.replace("3 0 1 2", "3 0 1"),
        PLY.replace("element face 1", "element face true"),
        PLY.replace("ascii", "binary_little_endian"),
        PLY[:60],
    ],
)
def test_a_ply_that_does_not_fit_never_reaches_its_reader(bad: str, tmp_path: Path) -> None:
    assert ply_fault(PLY.encode()) is None
    assert ply_fault(bad.encode()) is not None
    (tmp_path / "a.ply").write_text(bad)
    assert "export it again" in refusal_of(lambda: read_mesh(tmp_path / "a.ply"))
