"""A command read by itself: the same options as among all commands, or left to those."""

from __future__ import annotations

from functools import partial, wraps
from typing import Any

import pytest
import tyro

from planner.base.errors import OptionError
from planner.cli.alone import ALONE, read_alone
from planner.cli.catalogue import robots
from planner.cli.check import check
from planner.cli.plan import plan
from planner.cli.sweep import sweep

COMMANDS = {"plan": plan, "sweep": sweep, "check": check}
READ = [
    "plan",
    "plan --robot ur5 --beta 0.2 --goal home --out there --json --min_manipulability 0.1",
    "plan --request a.yaml --no-timing --jerk 30 --law=nominal --effort 3",
    "sweep --robot panda --roadmap a.npz --tool hand",
    "check path.csv --robot panda --scene shelf --margin 0.01",
]
LEFT = [
    "",
    "robots",
    "plan --help",
    "plan -h",
    "plan --rob ur5",
    "plan --beta",
    "plan --beta x",
    "sweep extra",
    "check",
]


@pytest.mark.parametrize("line", READ)
def test_the_options_are_those_that_all_commands_read(line: str) -> None:
    name, *options = line.split()

    @wraps(COMMANDS[name])
    def told(*values: Any, **named: Any) -> tuple[Any, ...]:
        return values, named

    app = tyro.extras.SubcommandApp()
    app.command(name=name)(told)
    app.command(robots)
    read = read_alone([name, *options])
    assert isinstance(read, partial)
    assert read.func is COMMANDS[name]
    assert (read.args, read.keywords) == app.cli(prog="planner", args=[name, *options])


@pytest.mark.parametrize("line", LEFT)
def test_help_and_what_is_wrong_are_left_to_all_commands(line: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert read_alone(line.split()) is None
    assert capsys.readouterr() == ("", "")


def test_a_number_out_of_range_is_refused_as_ever() -> None:
    with pytest.raises(OptionError, match="beta 2 is outside"):
        read_alone(["plan", "--beta", "2"])


def test_every_one_is_a_command() -> None:
    assert set(ALONE) == set(COMMANDS)
