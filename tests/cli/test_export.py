"""``planner check`` proves the files of ``planner export``."""

import json
from pathlib import Path

import pytest

from tests.cli.test_motion import WORLD
from tests.command_line import Run


@pytest.mark.parametrize("kind", ["ros-json", "csv"])
def test_an_exported_motion_is_proven_by_check(run: Run, timed_plan: Path, tmp_path: Path, kind: str) -> None:
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
