"""``planner export``: what it writes is proven by ``check``."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.test_motion import WORLD
from tests.command_line import Run


@pytest.mark.parametrize("kind", ["ros-yaml", "ros-json", "moveit", "csv", "npz"])
def test_what_is_exported_is_proven_by_check(run: Run, timed_plan: Path, tmp_path: Path, kind: str) -> None:
    file = tmp_path / f"motion.{ {'ros-yaml': 'yaml', 'ros-json': 'json', 'moveit': 'yaml'}.get(kind, kind) }"
    code, out, _ = run("export", str(timed_plan), "--format", kind, "--rate", "100", "--out", str(file))
    assert code == 0
    assert ("ros2 action send_goal" in out) == (kind == "ros-json")
    code, out, _ = run("check", str(file), *WORLD, "--json")
    assert code == 0
    report = json.loads(out)
    assert report["ok"]
    assert report["pieces"]["free"] == report["points"] - 1
    assert max(report["shares"].values()) <= 1.0 + 1e-6


def test_export_refuses_what_is_no_trajectory(run: Run, tmp_path: Path) -> None:
    for words, code in ((("export", str(tmp_path)), 3), (("export", str(tmp_path), "--rate", "0"), 2)):
        found, _, err = run(*words)
        assert found == code
        assert err.startswith("planner: error: ")
