"""Options are parts of requests: one definition each, which every command that has the option embeds."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import get_args, get_type_hints

import pytest
import tyro

from benchmarks.commands import bench
from planner.cli.app import COMMANDS
from planner.problem.request import LimitsRequest, LiveRequest, PlanRequest, TimingRequest, WorkersRequest

REQUESTS = (PlanRequest, TimingRequest, LiveRequest)
OWN_MEANING = {  # of options that a request has too, by command
    "robot_yaml": "a file is written for a robot alone: its tool, group and joints are those of no scene",
    "gabf": "networks, no robots: the seed alone",
    "optimum": "numbers of nodes",
    "gate": "a seed of chunks and obstacles",
    "attack": "a seed of searches",
    "roadmap": "rows of other programs, which know a robot, a scene and a number of nodes",
    "tool_paths": "several robots and scenes; a seed of paths",
    "tables": "published problems, at several betas",
    "tasks": "seeded scenes, and the number of nodes that tasks have",
}


def commands() -> Iterator[Callable]:
    for name, module in COMMANDS.items():
        found = getattr(import_module(module), name.replace("-", "_"))
        yield from _of(found)
    yield from _of(bench)


def _of(found: object) -> Iterator[Callable]:
    if isinstance(found, tyro.extras.SubcommandApp):
        for spec in found._subcommands.values():
            yield from _of(spec.target)
    else:
        assert callable(found)
        yield found


ALL = list(commands())


def definers(kind: type, option: str) -> list[type]:
    return [base for base in kind.__mro__ if option in inspect.get_annotations(base)]


@pytest.mark.parametrize("kind", REQUESTS, ids=lambda kind: kind.__name__)
def test_a_requests_option_has_one_definition(kind: type) -> None:
    """Robot, scene and margin have a second one, for a roadmap whose file says them where they are left out."""
    for field in dataclasses.fields(kind):
        found = [base.__name__ for base in definers(kind, field.name)]
        assert found in ([found[0]], ["WorldRequest", "KeptWorld"]), field.name
        assert len(found) == 1 or field.name in ("robot", "scene", "margin")


def test_requests_share_them() -> None:
    where: dict[str, type] = {}
    for kind in (*REQUESTS, WorkersRequest, LimitsRequest):
        for field in dataclasses.fields(kind):
            part = definers(kind, field.name)[0]
            assert where.setdefault(field.name, part) is part, field.name


def typed(command: Callable) -> tuple[set[str], set[str]]:
    """The options of requests that a command embeds, and those that it types by itself."""
    known = {field.name for kind in (*REQUESTS, WorkersRequest) for field in dataclasses.fields(kind)}
    embedded, own = set(), set()
    for name, hint in get_type_hints(command, include_extras=True).items():
        kinds = [kind for kind in (hint, *get_args(hint)) if inspect.isclass(kind) and dataclasses.is_dataclass(kind)]
        embedded |= {field.name for kind in kinds for field in dataclasses.fields(kind)}
        own |= set() if kinds else {name} & known
    return embedded, own


@pytest.mark.parametrize("command", ALL, ids=lambda command: f"{command.__module__}.{command.__name__}")
def test_no_command_types_one_again(command: Callable) -> None:
    embedded, own = typed(command)
    assert not own & embedded, "two options of one name"
    assert not own or command.__name__ in OWN_MEANING, f"{own}: embed the part that has them"


def test_every_exception_is_one() -> None:
    assert {command.__name__ for command in ALL if typed(command)[1]} == set(OWN_MEANING)
