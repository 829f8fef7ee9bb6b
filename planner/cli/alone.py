"""One command read by itself: the parsers of all others take as long to make as what it then does."""

from __future__ import annotations

import importlib
import io
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from functools import partial, wraps
from typing import Any

import tyro

ALONE = ("plan", "sweep", "check")  # each is the function of its name in the module of its name


def read_alone(arguments: Sequence[str]) -> Callable[[], int] | None:
    """The command with its options, ready to be called.

    None where the parser of all commands has the word: another command, a call for help, and whatever is wrong with
    the options, as its sentences point to other commands that know them.
    """
    if not arguments or arguments[0] not in ALONE:
        return None
    name = arguments[0]
    command = getattr(importlib.import_module(f"planner.cli.{name}"), name)

    @wraps(command)
    def read(*values: Any, **options: Any) -> Callable[[], int]:
        return partial(command, *values, **options)

    nowhere = io.StringIO()  # tyro tells of a value that does not parse whether it is to or not
    with redirect_stdout(nowhere), redirect_stderr(nowhere), suppress(SystemExit):
        return tyro.cli(read, prog=f"planner {name}", args=arguments[1:], console_outputs=False)
    return None
