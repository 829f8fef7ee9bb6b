"""The list of commands, and errors of the parser."""

from __future__ import annotations

import re
from importlib import import_module

import pytest

from planner.base.errors import OptionError
from planner.cli.app import COMMANDS, run


def test_help_names_every_command_in_order_with_its_summary(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    with pytest.raises(SystemExit) as end:
        run(["--help"])
    assert end.value.code == 0
    shown = capsys.readouterr().out
    usage = re.search(r"\{([\w,\s-]+)\}", shown)
    assert usage is not None
    assert re.sub(r"\s", "", usage[1]).split(",") == list(COMMANDS)
    for name, module in COMMANDS.items():
        summary = getattr(import_module(module), name.replace("-", "_")).__doc__.strip().splitlines()[0]
        assert re.search(rf"{name} +{re.escape(summary)}", shown)
    assert len(shown.splitlines()) < 30, "summaries, not all that is to be said of every command"


def test_an_unknown_command_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        run(["fly"])
    assert end.value.code == 2
    assert "fly" in capsys.readouterr().err


def test_a_number_out_of_range_is_refused_as_ever() -> None:
    with pytest.raises(OptionError, match="beta 2 is outside"):
        run(["plan", "--beta", "2"])
