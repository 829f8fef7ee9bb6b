"""All commands together, and each read by itself: the same options, and what is wrong is left to all."""

from __future__ import annotations

import re
from functools import partial, wraps
from importlib import import_module
from typing import Any

import pytest
import tyro

from planner.base.errors import OptionError
from planner.cli.app import COMMANDS, read_alone, run
from planner.cli.catalogue import robots

READ = [
    "plan",
    "plan --robot ur5 --beta 0.2 --goal home --out there --json --min_manipulability 0.1",
    "plan --request a.yaml --no-timing --jerk 30 --law=nominal --effort 3",
    "sweep --robot panda --roadmap a.npz --tool hand",
    "batch plans.csv --seed 3 --jobs 2",
    "check path.csv --robot panda --scene shelf --margin 0.01",
]
LEFT = [
    "",
    "robots --yaml",
    "roadmap info a.npz",
    "plan --help",
    "plan -h",
    "plan --rob ur5",
    "plan --beta",
    "plan --beta x",
    "sweep extra",
    "check",
]


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


@pytest.mark.parametrize("line", READ)
def test_the_options_are_those_that_all_commands_read(line: str) -> None:
    name, *options = line.split()

    command = getattr(import_module(COMMANDS[name]), name)

    @wraps(command)
    def told(*values: Any, **named: Any) -> tuple[Any, ...]:
        return values, named

    app = tyro.extras.SubcommandApp()
    app.command(name=name)(told)
    app.command(robots)
    read = read_alone([name, *options])
    assert isinstance(read, partial)
    assert read.func is command
    assert (read.args, read.keywords) == app.cli(prog="planner", args=[name, *options])


@pytest.mark.parametrize("line", LEFT)
def test_help_and_what_is_wrong_are_left_to_all_commands(line: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert read_alone(line.split()) is None
    assert capsys.readouterr() == ("", "")


def test_a_number_out_of_range_is_refused_as_ever() -> None:
    with pytest.raises(OptionError, match="beta 2 is outside"):
        read_alone(["plan", "--beta", "2"])
