"""``planner check`` as a user types it."""

import json
from pathlib import Path

import pytest

from tests.command_line import Run

EMPTY = ("--robot", "planar_2r", "--scene", "empty")


def made(run: Run, folder: Path, *more: str) -> Path:
    """A folder with a plan of an arm that no option of a check names."""
    ends = ("--start", "q:0,1", "--goal", "q:1,1", "--path-only", "--out", str(folder))
    assert run("plan", *EMPTY, *ends, *more)[0] == 0
    return folder


def test_robot_and_scene_are_those_of_the_plan_next_to_the_file(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = made(run, tmp_path, "--margin", "0.003", "--tool", "link_2")
    opened: list[str] = []
    for module in ("planner.tasks.check", "planner.trajectory.recorded"):
        monkeypatch.setattr(
            f"{module}.read_text", lambda path, what: opened.append(str(path)) or Path(path).read_text()
        )
    for name in ("", "plan.json", "trajectory.json"):
        opened.clear()
        code, out, err = run("check", str(folder / name), "--json")
        record = json.loads(out)
        assert (code, err) == (0, "")
        assert (record["robot"], record["scene"], record["margin"]) == ("planar_2r", "empty", 0.003)
        assert record["frame"] == "link_2"
        assert record["proven"]
        assert len(opened) == len(set(opened)), "each file is read once"
    (folder / "path.csv").write_text("joint_1,joint_2\n0,1\n1,1\n")
    assert json.loads(run("check", str(folder / "path.csv"), "--json")[1])["robot"] == "planar_2r"
    other = json.loads(run("check", str(folder), "--scene", "window", "--margin", "0", "--json")[1])
    assert (other["robot"], other["scene"], other["margin"]) == ("planar_2r", "window", 0.0)
    code, _, err = run("check", str(folder / "plan.json"), "--robot", "iiwa14")
    assert code == 3
    assert "must be for robot 'iiwa14', got 'planar_2r': choose it with --robot." in err
    (folder / "plan.json").write_text("{")
    assert run("check", str(folder / "path.csv"))[0] == 3
    assert run("check", str(folder / "path.csv"), *EMPTY)[0] == 0
