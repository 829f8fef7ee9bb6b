"""Every command prints a note on its robot once, however often it opens its world."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from planner.base.notes import LOGGER
from planner.kinematics.forward import tool_positions
from tests.command_line import Run
from tests.worlds import load

WORLD = ("--robot", "z1", "--scene", "empty")
ENDS = (*WORLD, "--start", "home", "--goal", "q:0.1,1.5,-1.0,-0.54,0,0", "--nodes", "20", "--effort", "0")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made, (at,) = tmp_path_factory.mktemp("notes"), tool_positions(load("z1"), load("z1").home).tolist()
    points = [{"position": position, "axis": [1, 0, 0]} for position in (at, [at[0] + 0.01, *at[1:]])]
    (made / "line.yaml").write_text(yaml.safe_dump({"points": points}))
    (made / "task.yaml").write_text("robot: z1\nscene: empty\nsteps: [{move: 'q:0.1,1.5,-1.0,-0.54,0,0'}]\n")
    return made


COMMANDS = {
    "plan": ("plan", *ENDS, "--out", "plan"),
    "check": ("check", "plan/trajectory.json", *WORLD),
    "export": ("export", "plan", "--rate", "1000", "--format", "csv"),
    "sweep": ("sweep", *ENDS, "--out", "sweep"),
    "follow": ("follow", "line.yaml", *WORLD, "--out", "follow"),
    "task": ("task", "task.yaml", "--nodes", "20", "--out", "task"),
    "roadmap": ("roadmap", "build", "roadmap.npz", *ENDS[:-2]),
}


def test_a_note_is_printed_once(
    folder: Path, run: Run, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    for name, words in COMMANDS.items():
        caplog.clear()
        code, _, error = run(*words)
        assert code == 0 or (name, code) == ("follow", 4), (name, error)
        told = [record.message for record in caplog.records if record.name == LOGGER]
        assert sum("link01, link05" in text for text in told) == len(told) == 1, name
