"""All commands of the command line, each imported when it is called, and the texts that options are read from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

import tyro

from planner.problem import options as of
from planner.problem.conditions import AND, conditions_of
from planner.problem.targets import Target, goals_of, parse_base, target_of

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
# a type of option: its word in the help, its value out of text, the text of a value
_TEXTS: tuple[tuple[Any, str, Callable[[str], Any], Callable[[Any], str]], ...] = (
    (of.RobotLike, "NAME|FILE", str, str),
    (of.RobotLike | None, "NAME|FILE", str, str),
    (of.Names | None, "NAME,...", str, ",".join),
    (of.Base | None, "NUMBER,...", parse_base, str),
    (of.Conditions, "CONDITION", conditions_of, lambda value: AND.join(each.text for each in value) or "none"),
    (Target, "STATE", target_of, lambda value: value.text),
    (Target | None, "STATE", target_of, lambda value: value.text),
    (of.Targets, "STATE", goals_of, lambda value: AND.join(each.text for each in value)),
    (of.Tolerance, "M,RAD", str, lambda value: ",".join(f"{each:g}" for each in value)),
)
registry = tyro.constructors.ConstructorRegistry()


@registry.primitive_rule
def _from_text(info: tyro.constructors.PrimitiveTypeInfo) -> tyro.constructors.PrimitiveConstructorSpec[Any] | None:
    """Read the options that are objects inside from one word each."""
    found = next((row for row in _TEXTS if info.type == row[0]), None)
    if found is None:
        return None
    _, word, parse, text = found
    return tyro.constructors.PrimitiveConstructorSpec(
        nargs=1,
        metavar=word,
        instance_from_str=lambda words: parse(words[0]),
        is_instance=lambda value: True,
        str_from_instance=lambda value: ["None" if value is None else text(value)],
    )


def run(arguments: Sequence[str]) -> int:
    """Run the command that ``arguments`` name and return its exit code; help and wrong options end the process."""
    command: Any = _command(arguments[0]) if arguments and arguments[0] in COMMANDS else None
    with registry:
        if command is not None and not isinstance(command, tyro.extras.SubcommandApp):
            return tyro.cli(
                command, prog=f"planner {arguments[0]}", args=arguments[1:], config=(tyro.conf.OmitArgPrefixes,)
            )
        return _all(summaries=arguments[:1] in (["-h"], ["--help"])).cli(
            prog="planner",
            description="Singularity-averse path planning for robot arms: proven edges, certified cost-to-go. "
            "'planner --version' says which this is, 'planner COMMAND --help' what a command does.",
            args=arguments,
            config=(tyro.conf.OmitArgPrefixes,),
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
