"""MoveIt's files by the command: what is not honoured is refused with exit code 3, in one sentence, or noted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.command_line import Run, assert_refused
from tests.robot.files.moveit.samples import REQUEST, SCENE, changed

TILTED = {"orientation_constraints": [{"link_name": "panda_hand", "orientation": [1, 0, 0, 0]}]}


def options(folder: Path, scene: dict[str, Any], request: dict[str, Any]) -> list[str]:
    for name, message in (("s.yaml", scene), ("r.yaml", request)):
        (folder / name).write_text(yaml.safe_dump(message))
    files = ["--scene", str(folder / "s.yaml"), "--request", str(folder / "r.yaml")]
    return ["plan", "--robot", "panda", *files, "--collision", "coal", "--path-only", "--out", str(folder / "out")]


@pytest.mark.parametrize(
    ("scene", "request_", "part"),
    [
        (
            SCENE,
            changed(REQUEST, "trajectory_constraints", {"constraints": [TILTED]}),
            "'trajectory_constraints' is not followed",
        ),
        (changed(SCENE, "world.octomap.octomap.data", [1]), REQUEST, "give boxes or meshes in its place"),
        (changed(SCENE, "world.collision_objects.0.header.frame_id", "panda_link5"), REQUEST, "moves with the arm"),
        (SCENE, changed(REQUEST, "goal_constrains", [TILTED]), "(did you mean 'goal_constraints'?)"),
    ],
)
def test_what_would_change_the_answer_is_refused(
    scene: dict[str, Any], request_: dict[str, Any], part: str, tmp_path: Path, run: Run
) -> None:
    assert_refused(run(*options(tmp_path, scene, request_)), 3, part, tmp_path / "out")


def test_what_is_honoured_and_what_is_noted_stand_in_the_record(
    tmp_path: Path, run: Run, caplog: pytest.LogCaptureFixture
) -> None:
    request = changed(changed(REQUEST, "max_velocity_scaling_factor", 0.2), "planner_id", "RRTConnect")
    arguments = options(tmp_path, changed(SCENE, "is_diff", True), request)
    code, _, _ = run(*arguments, "--velocity-scale", "0.5")
    assert code == 0
    assert "to a scene that is not here" in caplog.text
    record = json.loads((tmp_path / "out" / "plan.json").read_text())
    settings, difference = sorted(record["notes"])
    assert "is a difference" in difference
    assert settings.endswith("no path depends on it: planner_id.")
    assert "times 0.5 (in place of the request's 0.2)" in record["trajectory"]["limits"]
