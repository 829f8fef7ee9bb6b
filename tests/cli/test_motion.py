"""``planner plan`` writes a trajectory, ``export`` turns it into other formats, ``check`` proves or refutes those."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.command_line import Run

PLAN = ("plan", "--robot", "planar_2r", "--scene", "empty", "--start", "q:-1,0.5", "--goal", "q:1,0.9", "--nodes", "60")
WORLD = ("--robot", "planar_2r", "--scene", "empty")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a plan and its trajectory."""
    from planner.base.request import PlanRequest, TimingRequest
    from planner.plan_record import save_plan_without_page
    from planner.planning import plan

    folder = tmp_path_factory.mktemp("made")
    request = PlanRequest("planar_2r", "empty", start="q:-1,0.5", goal="q:1,0.9", nodes=60)
    save_plan_without_page(plan(request, timing=TimingRequest()), folder)
    return folder


def test_plan_writes_a_trajectory_and_says_how_long_it_takes(run: Run, tmp_path: Path) -> None:
    code, out, _ = run(*PLAN, "--out", str(tmp_path), "--acceleration", "3")
    assert code == 0
    record = json.loads((tmp_path / "trajectory.json").read_text())
    summary = json.loads((tmp_path / "plan.json").read_text())["trajectory"]
    assert record["proven"] is summary["proven"] is True
    assert record["limits"]["acceleration"] == [3.0, 3.0]
    assert f"{record['duration']:.3f} s" in out
    assert "--acceleration 3" in " ".join(out.split())
    points = record["points"]
    np.testing.assert_allclose(points[0]["q"], [-1, 0.5])
    np.testing.assert_allclose(points[-1]["q"], [1, 0.9])
    assert points[0]["t"] == 0
    assert (np.diff([point["t"] for point in points]) > 0).all()
    code, _, _ = run(*PLAN, "--out", str(tmp_path), "--no-timing")
    assert code == 0
    assert not (tmp_path / "trajectory.json").exists()
    assert json.loads((tmp_path / "plan.json").read_text())["trajectory"] is None


@pytest.mark.parametrize(
    "words", [("--acceleration", "0"), ("--velocity-scale", "nan"), ("--jerk", "-5"), ("--limits", "no.yaml")]
)
def test_bad_limits_write_nothing(run: Run, tmp_path: Path, words: tuple[str, str]) -> None:
    code, _, err = run(*PLAN, "--out", str(tmp_path / "none"), *words)
    assert code == 3
    assert err.strip().count("\n") == 0
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("kind", ["ros-yaml", "ros-json", "moveit", "csv", "npz"])
def test_what_is_exported_is_proven_by_check(run: Run, made: Path, tmp_path: Path, kind: str) -> None:
    file = tmp_path / f"motion.{ {'ros-yaml': 'yaml', 'ros-json': 'json', 'moveit': 'yaml'}.get(kind, kind) }"
    code, out, _ = run("export", str(made), "--format", kind, "--rate", "100", "--out", str(file))
    assert code == 0
    assert ("ros2 action send_goal" in out) == (kind == "ros-json")
    code, out, _ = run("check", str(file), *WORLD, "--json")
    assert code == 0
    report = json.loads(out)
    assert report["ok"]
    assert report["pieces"]["free"] == report["points"] - 1
    assert max(report["shares"].values()) <= 1.0 + 1e-6


def test_check_of_a_trajectory_in_words(run: Run, made: Path) -> None:
    code, out, _ = run("check", str(made), *WORLD)
    assert code == 0
    assert "Free and within all limits" in out
    code, out, _ = run("check", str(made), *WORLD, "--acceleration-scale", "0.5")
    assert code == 4
    assert "over its limit of 2.5" in out


def test_export_refuses_what_is_no_trajectory(run: Run, tmp_path: Path) -> None:
    for words, code in ((("export", str(tmp_path)), 3), (("export", str(tmp_path), "--rate", "0"), 2)):
        found, _, err = run(*words)
        assert found == code
        assert err.startswith("planner: error: ")
