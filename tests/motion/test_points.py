"""Trajectories of any origin."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import FileError
from planner.motion.export import export
from planner.motion.points import Points, read_points
from tests.motion.test_export import ARM, MADE, A, B, read_back


def test_columns_go_by_name_and_others_are_left_out(tmp_path: Path) -> None:
    message = json.loads(export(MADE, "ros-json"))
    message["joint_names"] = ["finger", B, A]
    for point in message["points"]:
        for key in ("positions", "velocities", "accelerations"):
            point[key] = [0.02, *point[key][::-1]]
    for wrapped in (message, {"trajectory": message}, {"goal": {"trajectory": message}}):
        found = read_back(json.dumps(wrapped).encode(), "ros-json", tmp_path)
        np.testing.assert_allclose(found.coefficients, MADE.coefficients, atol=1e-14)


@pytest.mark.parametrize(
    ("times", "columns", "words"),
    [
        ([0, 1, 1], [[[0, 0]] * 3], "from point 2 to point 3 (1 s, 1 s)"),
        ([-0.5, 1], [[[0, 0]] * 2], "0.5 s before the start"),
        ([0, 1], [[[0, 0]] * 2, [[0, 0], [0, 0.3]]], "'joint_2' ends with 0.3"),
    ],
)
def test_what_no_controller_runs_has_a_reason(times: list, columns: list, words: str) -> None:
    points = Points(ARM.joints, np.array(times, dtype=float), tuple(np.array(rows, dtype=float) for rows in columns))
    assert words in (points.fault() or "")


@pytest.mark.parametrize(
    ("columns", "kind"), [(["q"], "lines"), (["q", "qd"], "cubics")], ids=["positions", "with velocities"]
)
def test_what_is_given_decides_what_runs_between(columns: list[str], kind: str, tmp_path: Path) -> None:
    arrays = {"t": np.array([0.0, 1.0]), "q": np.array([[0.0, 0.0], [0.5, 0.1]]), "qd": np.zeros((2, 2))}
    np.savez(tmp_path / "a.npz", **{key: arrays[key] for key in ("t", *columns)})
    points = read_points(tmp_path / "a.npz", ARM)
    assert points is not None
    assert points.trajectory().interpolation == kind


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.yaml", "points: 3", "holds no trajectory"),
        ("a.csv", "t,joint_1,joint_2\n0,0,0\n1,x,0\n", "point 2 holds a number"),
        ("a.csv", "t,joint_1,joint_2\n0,0,0\n", "holds one point"),
        ("a.json", '{"points": [{"positions": [0, 0], "time_from_start": "soon"}]}', "is no time"),
        ("a.npz", "PK", "no .npz"),
    ],
)
def test_what_cannot_be_read_is_a_sentence(name: str, text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(FileError, match=words):
        read_points(tmp_path / name, ARM)


def test_a_path_without_times_is_none(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("joint_1,joint_2\n0,0\n1,1\n")
    assert read_points(tmp_path / "a.csv", ARM) is None


@pytest.mark.parametrize("place", [0, 60, 200])
def test_damaged_arrays_are_refused(place: int, tmp_path: Path) -> None:
    content = bytearray(export(MADE, "npz"))
    content[place] ^= 0xFF
    (tmp_path / "a.npz").write_bytes(content)
    with pytest.raises(FileError, match=r"is no \.npz with t, q and qd"):
        read_points(tmp_path / "a.npz", ARM)
