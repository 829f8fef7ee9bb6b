"""The table of commands, the parser of options, and the order of words that the parser needs."""

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, get_args

import tyro

from planner.base.errors import OptionError
from planner.cli.terminal import say
from planner.problem import options as option
from planner.problem.conditions import AND, read_conditions
from planner.problem.targets import Target, parse_base, read_goals, read_target

COMMANDS = {  # each is the function of its name in this module of planner.cli; in the order of the help
    "plan": "plan",
    "follow": "plan",
    "sweep": "plan",
    "task": "plan",
    "batch": "plan",
    "view": "view",
    "check": "check",
    "serve": "view",
    "verify": "check",
    "schema": "catalogue",
    "export": "export",
    "robots": "catalogue",
    "scenes": "catalogue",
    "robot-yaml": "robot_yaml",
    "roadmap": "roadmap",
}
_SEVERAL = ("--goal", "--constraint")
# type of an option, its word in the help, function from text to value, function from value to text
_TEXTS: tuple[tuple[Any, str, Callable[[str], Any], Callable[[Any], str]], ...] = (
    (option.RobotLike, "NAME|FILE", str, str),
    (option.RobotLike | None, "NAME|FILE", str, str),
    (str | None, "NAME", str, str),
    (Path | None, "FILE", Path, str),
    (int | None, "INT", int, str),
    (float | None, "FLOAT", float, str),
    (option.Measure, "|".join(get_args(option.MeasureName)), str, str),
    (option.Names | None, "NAME,...", str, ",".join),
    (option.Base | None, "NUMBER,...", parse_base, str),
    (option.Conditions, "CONDITION", read_conditions, lambda value: AND.join(each.text for each in value) or "none"),
    (Target, "STATE", read_target, lambda value: value.text),
    (Target | None, "STATE", read_target, lambda value: value.text),
    (option.Targets, "STATE", read_goals, lambda value: AND.join(each.text for each in value)),
    (option.Area | None, "X0,Y0,X1,Y1", str, lambda value: ",".join(f"{each:g}" for each in value)),
    (option.Tolerance, "M,RAD", str, lambda value: ",".join(f"{each:g}" for each in value)),
)
registry = tyro.constructors.ConstructorRegistry()


@registry.primitive_rule
def _from_text(info: tyro.constructors.PrimitiveTypeInfo) -> tyro.constructors.PrimitiveConstructorSpec[Any] | None:
    """Return how one word becomes the value of an option whose type is in ``_TEXTS``."""
    row = next((row for row in _TEXTS if info.type == row[0]), None)
    if row is None:
        return None
    _, word, parse, text = row
    return tyro.constructors.PrimitiveConstructorSpec(
        nargs=1,
        metavar=word,
        instance_from_str=lambda words: parse(words[0]),
        is_instance=lambda value: True,
        str_from_instance=lambda value: ["none" if value is None else text(value)],
    )


def run(words: Sequence[str]) -> int:
    """Run the command in ``words`` and return its exit code; help and wrong options exit the process."""
    if list(words) == ["--version"]:
        from planner.base.resources import __version__

        say(f"gabf-planner {__version__}")
        return 0
    words = merge_options(words)
    command: Any = _command(words[0]) if words and words[0] in COMMANDS else None
    config = (tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff)
    with registry:
        if command is not None and not isinstance(command, tyro.extras.SubcommandApp):
            return tyro.cli(command, prog=f"planner {words[0]}", args=words[1:], config=config)
        every = tyro.extras.SubcommandApp()
        for name in COMMANDS:
            command = _command(name)
            summary = command.__doc__.strip().splitlines()[0] if words[:1] in (["-h"], ["--help"]) else None
            every.command(name=name, help=summary)(command)
        return every.cli(
            prog="planner",
            description="Plans motions of robot arms away from obstacles and singular configurations.\n"
            "Help of a command: planner COMMAND --help. Version: planner --version.",
            args=words,
            config=config,
        )


def _command(name: str) -> Any:
    return getattr(import_module(f"planner.cli.{COMMANDS[name]}"), name.replace("-", "_"))


def merge_options(words: Sequence[str]) -> list[str]:
    """Return the words with all ``--goal`` joined at the first one, and all ``--constraint`` too.

    With ``--cell`` also all ``--start``.
    Raises :class:`OptionError` for another option that is given twice, as the parser would take the last one, and for
    an empty word, as an empty folder would be the shell's own.
    """
    out: list[str] = []
    cell = any(word == "--cell" or word.startswith("--cell=") for word in words)
    several = (*_SEVERAL, "--start") if cell else _SEVERAL
    at: dict[str, int] = {}  # where the value of an option stands in ``out``
    waiting = iter(words)
    for word in waiting:
        option, equals, value = word.partition("=")
        option = option.replace("_", "-")
        if not option.startswith("--"):
            option = ""
        elif option in several and not equals:
            value = next(waiting, None)
        if not word or (option and equals and not value):
            raise OptionError(f"{option or 'an argument'} must have a value, got an empty text: leave it out.")
        if option in at and option not in several:
            raise OptionError(f"{option} must be given once, got it twice: remove one.")
        if option in at and value:
            out[at[option]] += AND + value
            continue
        if option:
            at[option] = len(out) + 1
        out += [option, value] if option in several and value is not None else [word]
    return out
