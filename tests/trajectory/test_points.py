"""Trajectories of any origin."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import FileError
from planner.trajectory.export import export
from planner.trajectory.points import Points, read_motion
from tests.trajectory.test_export import ARM, MADE, A, B, read_back
from tests.trajectory.test_messages import OURS, message


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
    ("columns", "kind"), [(["q"], "lines"), (["q", "qd"], "cubics")], ids=["positions", "with velocities"]
)
def test_what_is_given_decides_what_runs_between(columns: list[str], kind: str, tmp_path: Path) -> None:
    names = ["t", A, B, *(f"{joint}_velocity" for joint in (A, B) if "qd" in columns)]
    rows = [[0.0] * len(names), [1.0, 0.5, 0.1, 0.0, 0.0][: len(names)]]
    (tmp_path / "a.csv").write_text("\n".join(",".join(map(str, row)) for row in [names, *rows]))
    points = read_motion(tmp_path / "a.csv", ARM)
    assert isinstance(points, Points)
    assert points.trajectory().interpolation == kind


def test_accelerations_without_velocities_are_not_read_as_velocities(tmp_path: Path) -> None:
    """A ROS 2 controller interpolates nothing then, and commands zeros."""
    bare = message(velocities=[])
    bare["points"][0]["velocities"] = []
    (tmp_path / "a.json").write_text(json.dumps(bare))
    (tmp_path / "a.csv").write_text(f"t,{A},{B},{A}_acceleration,{B}_acceleration\n0,0,0,0,0\n1,1,1,0,0\n")
    ours = {**OURS, "points": [{"t": p["t"], "q": p["q"], "qdd": p["qdd"]} for p in OURS["points"]]}
    (tmp_path / "b.json").write_text(json.dumps(ours))
    for name in ("a.json", "a.csv", "b.json"):
        with pytest.raises(FileError, match="accelerations and no velocities"):
            read_motion(tmp_path / name, ARM)


def test_what_is_left_aside_is_noted(tmp_path: Path) -> None:
    wrapped = {
        "goal": {
            "trajectory": message(effort=[1.0, 1.0], header={"stamp": {"sec": 5, "nanosec": 0}}),
            "goal_time_tolerance": {"sec": 1, "nanosec": 0},
            "path_tolerance": [],
        }
    }
    (tmp_path / "a.yaml").write_text(json.dumps(wrapped) + "\n---\n" + json.dumps(message()) + "\n---\n")
    points = read_motion(tmp_path / "a.yaml", ARM)
    assert isinstance(points, Points)
    noted = "; ".join(points.notes)
    for words in ("first of 2 documents", "goal_time_tolerance of the message", "the header's stamp", "effort is not"):
        assert words in noted
    (tmp_path / "a.json").write_text(json.dumps(message()))
    plain = read_motion(tmp_path / "a.json", ARM)
    assert isinstance(plain, Points)
    assert plain.notes == ()


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.yaml", "points: 3", "holds no trajectory"),
        ("a.csv", "t,joint_1,joint_2\n0,0,0\n1,x,0\n", "row 2 holds something that is no number"),
        ("a.csv", "t,joint_1,joint_2\n0,0,0\n", "holds one point"),
        ("a.csv", "t,joint_1,joint_2,joint_1_velocity\n0,0,0,0\n1,0,0,0\n", "no column joint_2_velocity"),
        ("a.csv", "t,joint_1,joint_2,joint_1_velocity_deg\n0,0,0,0\n", "did you mean 'joint_1_vel"),
        ("a.json", '{"points": [{"positions": [0, 0], "time_from_start": "soon"}]}', "is no time"),
    ],
)
def test_what_cannot_be_read_is_a_sentence(name: str, text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(FileError, match=words):
        read_motion(tmp_path / name, ARM)
