"""``planner check`` as a user types it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.command_line import Run

WINDOW = ("--robot", "planar_2r", "--scene", "window")
FREE = [[-2.0, 0.3], [-2.5, 0.5], [-2.2, 0.4]]
THROUGH = [[-2.0, 0.3], [0.0, 0.3], [1.5, 0.3]]


def written(folder: Path, rows: list[list[float]]) -> str:
    path = folder / "path.json"
    path.write_text(json.dumps(rows))
    return str(path)


def test_a_plan_of_ours(run: Run, tmp_path: Path) -> None:
    made = ("--robot", "planar_2r", "--scene", "empty")
    code, _, _ = run("plan", *made, "--start", "q:0,1", "--goal", "q:1,1", "--nodes", "20", "--out", str(tmp_path))
    assert code == 0
    code, out, err = run("check", str(tmp_path / "plan.json"), *made)
    assert code == 0, err
    assert "within limits" in out
    assert "proven free as a whole" in out
    code, _, err = run("check", str(tmp_path / "plan.json"))
    assert code == 3
    assert "is for robot 'planar_2r', not 'iiwa14': choose it with --robot." in err


@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_free_and_not_free(run: Run, tmp_path: Path, backend: str) -> None:
    code, out, err = run("check", written(tmp_path, FREE), *WINDOW, "--collision", backend)
    assert code == 0, err
    assert "Free and within limits" in out
    code, out, err = run("check", written(tmp_path, THROUGH), *WINDOW, "--collision", backend)
    assert code == 4, err
    assert "Not usable: 'link_" in out
    assert "touch in segment" in out


def test_json_on_standard_output_and_nothing_else(run: Run, tmp_path: Path) -> None:
    code, out, err = run("check", written(tmp_path, THROUGH), *WINDOW, "--json")
    record = json.loads(out)
    assert code == 4
    assert err == ""
    assert record["ok"] is False
    contact = record["contact"]
    a, b = (np.array(row) for row in THROUGH[contact["segment"] : contact["segment"] + 2])
    np.testing.assert_allclose(contact["q"], a + contact["share"] * (b - a))
    assert contact["pair"][0].startswith("link_")
    assert {"limits", "clearance", "segments", "manipulability", "path_length", "message"} <= set(record)


def test_step_margin_and_tool_matter(run: Run, tmp_path: Path) -> None:
    path = written(tmp_path, FREE)
    plain = json.loads(run("check", path, *WINDOW, "--json")[1])
    gap = plain["clearance"]["smallest"]
    assert gap > 0.02
    code, out, _ = run("check", path, *WINDOW, "--margin", str(gap + 0.01))
    assert code == 4
    assert "closer than the margin" in out
    assert json.loads(run("check", path, *WINDOW, "--json", "--step", "0.01")[1])["step"] == 0.01
    tool = json.loads(run("check", path, *WINDOW, "--json", "--tool", "link_2")[1])
    assert tool["manipulability"]["frame"] == "link_2"
    assert tool["path_length"]["workspace"] != plain["path_length"]["workspace"]


def test_degrees_are_told_at_once(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Such a path is hundreds of metres long: looking at all of it took minutes."""
    for question in ("path_contact", "smallest_clearance", "prove_path"):
        monkeypatch.setattr(f"planner.trajectory.path_check.{question}", lambda *_: pytest.fail("it was looked at"))
    rows = np.degrees(FREE).tolist()
    code, out, err = run("check", written(tmp_path, rows), *WINDOW)
    assert code == 4, err
    assert "degrees?" in out
    record = json.loads(run("check", written(tmp_path, rows), *WINDOW, "--json")[1])
    assert record["degrees"] is True
    assert record["segments"] == {"free": 0, "collides": 0, "undecided": 2}


def test_a_trajectory_is_judged_by_its_own_limits_whatever_it_is_called(run: Run, tmp_path: Path) -> None:
    made = ("--robot", "planar_2r", "--scene", "empty")
    slow = ("--start", "q:0,1", "--goal", "q:1,1", "--path-only", "--velocity-scale", "0.3", "--out", str(tmp_path))
    assert run("plan", *made, *slow)[0] == 0
    record = json.loads((tmp_path / "trajectory.json").read_text())
    record["limits"]["velocity"] = [0.01, 0.01]
    for name in ("trajectory.json", "motion.json"):
        (tmp_path / name).write_text(json.dumps(record))
        code, out, _ = run("check", str(tmp_path / name), *made)
        assert code == 4
        assert "over its limit of 0.01" in out
    record["limits"]["velocity"] = [float("nan"), 0.01]
    (tmp_path / "motion.json").write_text(json.dumps(record))
    assert run("check", str(tmp_path / "motion.json"), *made)[0] == 3


@pytest.mark.parametrize(("kind", "says"), [("velocity", "beyond the URDF's"), ("acceleration", "is said to be the")])
def test_limits_that_the_robot_does_not_have_are_no_measure(kind: str, says: str, run: Run, tmp_path: Path) -> None:
    """Else a file makes any motion one within limits, and says that these are the robot's."""
    made = ("--robot", "planar_2r", "--scene", "empty")
    assert run("plan", *made, "--start", "q:0,1", "--goal", "q:1,1", "--path-only", "--out", str(tmp_path))[0] == 0
    record = json.loads((tmp_path / "trajectory.json").read_text())
    record["limits"][kind] = [100.0, 100.0]
    (tmp_path / "trajectory.json").write_text(json.dumps(record))
    code, out, error = run("check", str(tmp_path / "trajectory.json"), *made)
    assert (code, out) == (3, "")
    assert says in " ".join(error.split())
    assert run("check", str(tmp_path / "trajectory.json"), *made, "--acceleration", "100")[0] == 0
    code, _, error = run("export", str(tmp_path), "--format", "csv", "--rate", "100")
    assert says in " ".join(error.split())
    assert "the motion on the grid is not proven" in " ".join(error.split())
