"""All commands of the command line. A command is imported when it is called."""

from __future__ import annotations

from collections.abc import Sequence
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
    """Run the command that ``arguments`` name and return its exit code; help and wrong options end the process."""
    command: Any = _command(arguments[0]) if arguments and arguments[0] in COMMANDS else None
    if command is not None and not isinstance(command, tyro.extras.SubcommandApp):
        return tyro.cli(command, prog=f"planner {arguments[0]}", args=arguments[1:])
    return _all(summaries=arguments[:1] in (["-h"], ["--help"])).cli(
        prog="planner",
        description="Singularity-averse path planning for robot arms: proven edges, certified cost-to-go. "
        "'planner --version' says which this is, 'planner COMMAND --help' what a command does.",
        args=arguments,
    )


def _command(name: str) -> Any:
    return getattr(import_module(COMMANDS[name]), name.replace("-", "_"))


def _all(summaries: bool) -> tyro.extras.SubcommandApp:
    """All commands, each with its whole help or with the first sentence of it."""
    app = tyro.extras.SubcommandApp()
    for name in COMMANDS:
        command = _command(name)
        app.command(name=name, help=command.__doc__.strip().splitlines()[0] if summaries else None)(command)
    return app
