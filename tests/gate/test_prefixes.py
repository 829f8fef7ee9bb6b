"""``planner check TRAJECTORY --prefixes``: until when a trajectory can be left."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from planner.kinematics.forward import tool_pose
from tests.command_line import Run
from tests.worlds import load

HERE, STEP = np.array([0.3, 0.4]), np.array([0.1, 0.0])


def written(folder: Path, ball: np.ndarray) -> tuple[str, ...]:
    """A scene with a ball, and lines at 1 rad/s; as the command line is given them."""
    scene, path = folder / "ball.yaml", folder / "trajectory.csv"
    place = [float(value) for value in ball]
    obstacle = {"name": "ball", "type": "sphere", "radius": 0.03, "position": place}
    scene.write_text(json.dumps({"name": "ball", "obstacles": [obstacle]}))
    rows = [",".join(map(str, (0.1 * k, *(HERE + k * STEP)))) for k in range(7)]
    path.write_text("\n".join(["t," + ",".join(load("planar_2r").joints), *rows]) + "\n")
    return str(path), "--robot", "planar_2r", "--scene", str(scene)


def tip(steps: float) -> np.ndarray:
    return tool_pose(load("planar_2r"), HERE + steps * STEP).translation


def test_a_trajectory_that_cannot_be_left_before_a_wall_is_refused(run: Run, tmp_path: Path) -> None:
    given = written(tmp_path, tip(6.6))
    code, out, err = run("check", *given, "--prefixes", "--json")
    found = json.loads(out)
    assert found["contact"] is None, err
    assert code == 4
    stops = found["prefixes"]
    assert stops["safe"] is False
    assert 0.1 < stops["safe_until"] < 0.6
    assert stops["reason"]["on"] == "stop"
    assert stops["reason"]["pair"][1] == "ball"
    assert "acceleration and jerk are not judged" in stops["notes"][0]
    assert "prefixes" not in json.loads(run("check", *given, "--json")[1])


def test_our_own_motions_can_be_left_anywhere(run: Run, tmp_path: Path) -> None:
    world = ("--robot", "planar_2r", "--scene", "empty")
    plan = run("plan", *world, "--start", "q:0,1", "--goal", "q:1,1", "--nodes", "20", "--out", str(tmp_path))
    assert plan[0] == 0
    code, out, err = run("check", str(tmp_path / "trajectory.json"), *world, "--prefixes", "--json")
    assert code == 0, err
    assert json.loads(out)["prefixes"]["safe"] is True
