"""All commands together."""

from __future__ import annotations

import re

import pytest

from planner.cli.app import run

COMMANDS = ["plan", "sweep", "batch", "view", "check", "schema", "export", "robots", "scenes", "robot-yaml"]
GROUPS = ["roadmap", "reproduce"]


def test_help_names_every_command_in_order(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    with pytest.raises(SystemExit) as end:
        run(["--help"])
    assert end.value.code == 0
    usage = re.search(r"\{([\w,\s-]+)\}", capsys.readouterr().out)
    assert usage is not None
    assert re.sub(r"\s", "", usage[1]).split(",") == [*COMMANDS, *GROUPS]


def test_an_unknown_command_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        run(["fly"])
    assert end.value.code == 2
    assert "fly" in capsys.readouterr().err
