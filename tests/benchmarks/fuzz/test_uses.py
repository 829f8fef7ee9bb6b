"""What is done with a file refuses what a command would refuse."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.fuzz import mesh_files, uses
from planner.base.errors import PlannerError
from planner.models.scene import Scene


@pytest.mark.parametrize(
    ("use", "name"),
    [
        (uses.use_robot, "a.urdf"),
        (uses.use_scene, "a.yaml"),
        (uses.use_mesh, "a.stl"),
        (uses.use_request, "a.yaml"),
        (uses.use_path, "a.json"),
        (uses.use_trajectory, "a.csv"),
        (uses.use_limits, "a.yaml"),
        (uses.use_roadmap, "a.npz"),
        (uses.use_network, "a.npz"),
        (uses.use_robot_file, "a.yaml"),
        (uses.use_batch, "a.yaml"),
        (uses.use_record, "a.json"),
    ],
)
def test_nonsense_is_refused(use, name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("no such thing: [")
    with pytest.raises(PlannerError):
        use(tmp_path / name)


def test_a_mesh_is_looked_at_as_an_obstacle_and_as_a_link(tmp_path: Path) -> None:
    (tmp_path / "part.stl").write_bytes(mesh_files.stl())
    uses.use_mesh(tmp_path / "part.stl")
    (obstacle,) = Scene.load(str(tmp_path / "part.yaml")).obstacles
    assert obstacle.name == "part"
    assert "part.stl" in (tmp_path / "part.urdf").read_text()
