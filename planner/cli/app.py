"""All commands of the command line: the one that is called is loaded and read by itself, the others only for help."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from functools import partial, wraps
from importlib import import_module
from typing import Any

import tyro

COMMANDS = {  # each is what has its name in this module; in the order of the help
    "plan": "planner.cli.plan",
    "follow": "planner.cli.follow",
    "sweep": "planner.cli.sweep",
    "task": "planner.cli.task",
    "batch": "planner.cli.batch",
    "view": "planner.cli.view",
    "check": "planner.cli.check",
    "serve": "planner.cli.serve",
    "verify": "planner.cli.verify",
    "schema": "planner.cli.schema",
    "export": "planner.cli.export",
    "robots": "planner.cli.catalogue",
    "scenes": "planner.cli.catalogue",
    "robot-yaml": "planner.cli.robot_yaml",
    "roadmap": "planner.cli.roadmap",
}


def run(arguments: Sequence[str]) -> int:
    """The exit code of the command that ``arguments`` ask for; help and what is wrong with them ends the process."""
    command = read_alone(arguments)
    if command is not None:
        return command()
    return _all(summaries=arguments[:1] in (["-h"], ["--help"])).cli(
        prog="planner",
        description="Singularity-averse path planning for robot arms: proven edges, certified cost-to-go. "
        "'planner --version' says which this is, 'planner COMMAND --help' what a command does.",
        args=arguments,
    )


def read_alone(arguments: Sequence[str]) -> Callable[[], int] | None:
    """The command with its options, ready to be called: the parsers of all take as long to make as what it then does.

    None where that of all commands has the word: a group of commands, a call for help, and whatever is wrong with the
    options, as its sentences point to other commands that know them.
    """
    command: Any = _command(arguments[0]) if arguments and arguments[0] in COMMANDS else None
    if command is None or isinstance(command, tyro.extras.SubcommandApp):
        return None

    @wraps(command)
    def read(*values: Any, **options: Any) -> Callable[[], int]:
        return partial(command, *values, **options)

    nowhere = io.StringIO()  # tyro tells of a value that does not parse whether it is to or not
    with redirect_stdout(nowhere), redirect_stderr(nowhere), suppress(SystemExit):
        return tyro.cli(read, prog=f"planner {arguments[0]}", args=arguments[1:], console_outputs=False)
    return None


def _command(name: str) -> Any:
    return getattr(import_module(COMMANDS[name]), name.replace("-", "_"))


def _all(summaries: bool) -> tyro.extras.SubcommandApp:
    """All commands, each with its whole help or with the first sentence of it."""
    app = tyro.extras.SubcommandApp()
    for name in COMMANDS:
        command = _command(name)
        app.command(name=name, help=command.__doc__.strip().splitlines()[0] if summaries else None)(command)
    return app
