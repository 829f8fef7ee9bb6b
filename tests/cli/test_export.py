"""``planner export``: what it writes is proven by ``check``."""

import json
from pathlib import Path

import pytest

from tests.cli.test_motion import WORLD
from tests.command_line import Run


@pytest.mark.parametrize("kind", ["ros-json", "csv"])
def test_what_is_exported_is_proven_by_check(run: Run, timed_plan: Path, tmp_path: Path, kind: str) -> None:
    file = tmp_path / f"motion.{kind.removeprefix('ros-')}"
    code, out, error = run("export", str(timed_plan), "--format", kind, "--rate", "100", "--out", str(file))
    assert (code, error) == (0, "")
    assert "one every 10 ms exactly; the end held to a row" in out
    assert "proven free and within limits" in out
    assert (f"python3 {tmp_path}/send_trajectory.py {file}" in "".join(out.splitlines())) == (kind == "ros-json")
    code, out, _ = run("check", str(file), *WORLD, "--json")
    assert code == 0
    report = json.loads(out)
    assert report["ok"]
    assert report["pieces"]["free"] == report["points"] - 1
    assert max(report["shares"].values()) <= 1.0 + 1e-6
    if kind == "csv":
        times = [line.split(",")[0] for line in file.read_text().splitlines()[1:]]
        grid = [f"{k // 100}.{k % 100:02d}0000000" for k in range(len(times))]
        assert times == grid


def test_a_grid_that_is_too_coarse_to_be_proven_is_not_written(run: Run, tmp_path: Path) -> None:
    window = ("plan", "--robot", "planar_2r", "--scene", "window", "--nodes", "60", "--out", str(tmp_path))
    assert run(*window)[0] == 0
    file = tmp_path / "coarse.csv"
    code, _, err = run("export", str(tmp_path), "--format", "csv", "--rate", "1", "--out", str(file))
    assert code == 3
    assert "on a grid of 1 Hz the motion is not proven as a whole any more" in err
    assert not file.exists()
    assert run("export", str(tmp_path), "--format", "csv", "--rate", "1000", "--out", str(file))[0] == 0
