"""What a message tells to do about it is an option of the command that says so: ``run`` sees to that in every test."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.command_line import Run, assert_remedies_are_options

BEYOND = "q:0,2.5,0,-1,0,1,0"
TASK = "robot: iiwa14\nscene: empty\nsteps: [{move: there}]\n"
_PRONG = (
    '<link name="{0}"/><joint name="j{0}" type="revolute"><parent link="base"/><child link="{0}"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
)
FORK = f'<robot name="fork"><link name="base"/>{_PRONG.format("left")}{_PRONG.format("right")}</robot>'
REFUSED = {
    "a task's start": (("task", "start.yaml"), "bring it inside."),
    "a task's move": (("task", "move.yaml"), "bring it inside."),
    "a task's state": (("task", "state.yaml"), "'gone' is not among the scene's states"),
    "a task's robot of two tips": (("task", "forked.yaml"), "the robot has 2 tips: name one as its tool"),
    "a plan's start": (("plan", "--robot", "iiwa14", "--scene", "empty", "--start", BEYOND), "--widen-limits"),
    "a plan's goal": (("plan", "--robot", "iiwa14", "--scene", "empty", "--goal", BEYOND), "--widen-limits"),
    "a tool path's start": (
        ("follow", "line.yaml", "--robot", "iiwa14", "--scene", "empty", "--start", BEYOND),
        "bring it inside.",
    ),
    "no trajectory to check": (("check", "trajectory.json"), ""),
    "no trajectory to export": (("export", "trajectory.json"), "plan first, with times"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_remedies_are_options(what: str, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "forked.yaml").write_text(TASK.replace("iiwa14", "fork.urdf"))
    (tmp_path / "fork.urdf").write_text(FORK)
    (tmp_path / "start.yaml").write_text(TASK + f"start: '{BEYOND}'\n")
    (tmp_path / "move.yaml").write_text(TASK.replace("there", f"'{BEYOND}'"))
    (tmp_path / "state.yaml").write_text(TASK.replace("empty", "scene.yaml"))
    (tmp_path / "scene.yaml").write_text("obstacles: []\nstates:\n  iiwa14: {there: gone}\n")
    (tmp_path / "line.yaml").write_text(
        "points:\n  - {position: [0.5, 0, 0.5], axis: [0, 0, -1]}\n  - {position: [0.5, 0.1, 0.5], axis: [0, 0, -1]}\n"
    )
    words, text = REFUSED[what]
    code, _, error = run(*words)
    assert code == 3, error
    assert text in error


def test_an_option_of_another_command_is_seen() -> None:
    told = "planner: error: joint 1 is out of its limits: widen them with --widen-limits."
    assert_remedies_are_options(["plan"], told)
    assert_remedies_are_options(["task"], told.replace("--widen-limits", "'planner plan --widen-limits'"))
    with pytest.raises(AssertionError, match=r"task has no {'--widen-limits'}"):
        assert_remedies_are_options(["task"], told)
