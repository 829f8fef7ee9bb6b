"""All commands, the words that they are given, and the texts that options are read from."""

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, get_args

import tyro

from planner.base.errors import OptionError
from planner.cli.terminal import say
from planner.problem import options as of
from planner.problem.conditions import AND, conditions_of
from planner.problem.targets import Target, goals_of, parse_base, target_of

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
# a type of option: its word in the help, its value out of text, the text of a value
_TEXTS: tuple[tuple[Any, str, Callable[[str], Any], Callable[[Any], str]], ...] = (
    (of.RobotLike, "NAME|FILE", str, str),
    (of.RobotLike | None, "NAME|FILE", str, str),
    (of.Measure, "|".join(get_args(of.MeasureName)), str, str),
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


def run(words: Sequence[str]) -> int:
    """Run the command that ``words`` name and return its exit code; help and wrong options end the process."""
    if list(words) == ["--version"]:
        from planner.base.resources import __version__

        say(f"gabf-planner {__version__}")
        return 0
    words = prepared(words)
    command: Any = _command(words[0]) if words and words[0] in COMMANDS else None
    config = (tyro.conf.OmitArgPrefixes,)
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
            description="Singularity-averse path planning for robot arms: proven edges, certified cost-to-go. "
            "'planner --version' says which this is, 'planner COMMAND --help' what a command does.",
            args=words,
            config=config,
        )


def _command(name: str) -> Any:
    return getattr(import_module(f"planner.cli.{COMMANDS[name]}"), name.replace("-", "_"))


def prepared(words: Sequence[str]) -> list[str]:
    """The words with all ``--goal`` made one, which stands where the first stood, and all ``--constraint``.

    Raises :class:`OptionError` for another option that is given twice, of which the parser would take the last, and
    for an empty word: an empty folder is the one that the shell stands in.
    """
    out: list[str] = []
    at: dict[str, int] = {}  # where the value of an option stands in ``out``
    waiting = iter(words)
    for word in waiting:
        option, equals, value = word.partition("=")
        option = option.replace("_", "-")
        if not option.startswith("--"):
            option = ""
        elif option in _SEVERAL and not equals:
            value = next(waiting, None)
        if not word or (option and equals and not value):
            raise OptionError(f"{option or 'a word'} is empty: give a value, or leave it out.")
        if option in at and option not in _SEVERAL:
            raise OptionError(f"option {option} is given twice: give it once.")
        if option in at and value:
            out[at[option]] += AND + value
            continue
        if option:
            at[option] = len(out) + 1
        out += [option, value] if option in _SEVERAL and value is not None else [word]
    return out
