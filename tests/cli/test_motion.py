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


def test_among_what_moves_a_plan_is_in_time_or_refused(run: Run, tmp_path: Path) -> None:
    scene, out = tmp_path / "ball.yaml", tmp_path / "out"
    way = "{t: 0, position: [2, 0.55, 0]}, {t: 2, position: [%s, 0.55, 0]}"
    ball = "{name: ball, type: sphere, radius: 0.1, motion: [" + way + "]}"
    words = ["plan", "--robot", "planar_2r", "--scene", str(scene), "--start", "q:-1,0.8", "--goal", "q:1,-0.8"]
    words += ["--nodes", "40", "--refinement-rounds", "0", "--out", str(out)]
    scene.write_text(f"obstacles: [{ball % '-2'}]")
    code, out, _ = run(*words)
    assert code == 0
    assert "proven clear of ball" in out
    assert json.loads((out / "plan.json").read_text())["trajectory"]["time_law"] == "safe-intervals"
    assert run("check", str(out / "trajectory.json"), "--robot", "planar_2r", "--scene", str(scene))[0] == 0
    scene.write_text(f"obstacles: [{ball % '0.7'}]")
    code, out, _ = run(*words)
    assert code == 4
    assert json.loads((out / "plan.json").read_text())["reason"]["obstacles"] == ["ball"]
    assert not (out / "trajectory.json").exists()
    code, _, err = run(*words[:-1], str(tmp_path / "none"), "--no-timing")
    assert code == 3
    assert "without --no-timing" in err
    assert not (tmp_path / "none").exists()
    assert run("roadmap", "build", str(tmp_path / "r.npz"), *words[1:11])[0] == 0
