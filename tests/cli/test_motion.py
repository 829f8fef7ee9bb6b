"""``planner plan`` writes a trajectory, ``export`` turns it into other formats, ``check`` proves or refutes those."""

import json
from pathlib import Path

import numpy as np

from tests.command_line import Run

PLAN = ("plan", "--robot", "planar_2r", "--scene", "empty", "--start", "q:-1,0.5", "--goal", "q:1,0.9", "--nodes", "60")
WORLD = ("--robot", "planar_2r", "--scene", "empty")


def test_plan_writes_a_trajectory_and_says_how_long_it_takes(run: Run, tmp_path: Path) -> None:
    code, out, _ = run(*PLAN, "--out", str(tmp_path), "--acceleration", "3", "--verbose")
    assert code == 0
    record = json.loads((tmp_path / "trajectory.json").read_text())
    summary = json.loads((tmp_path / "plan.json").read_text())["trajectory"]
    assert record["proven"] is summary["proven"] is True
    assert record["limits"]["acceleration"] == [3.0, 3.0]
    assert f"{record['duration']:.3f} s" in out
    assert "--acceleration 3" in " ".join(out.replace("│", " ").split())
    points = record["points"]
    np.testing.assert_allclose(points[0]["q"], [-1, 0.5])
    np.testing.assert_allclose(points[-1]["q"], [1, 0.9])
    assert points[0]["t"] == 0
    assert (np.diff([point["t"] for point in points]) > 0).all()
    code, _, _ = run(*PLAN, "--out", str(tmp_path), "--no-timing")
    assert code == 0
    assert not (tmp_path / "trajectory.json").exists()
    assert json.loads((tmp_path / "plan.json").read_text())["trajectory"] is None
