"""Errors end a command with 2 or 3, name the choices, and steer no terminal."""

import pytest

from planner.base import errors
from planner.base.errors import OptionError, PlannerError, printable

KINDS = [kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, PlannerError)]


@pytest.mark.parametrize("kind", KINDS)
def test_only_a_wrong_option_is_2(kind: type[PlannerError]) -> None:
    assert kind.exit_code == (2 if issubclass(kind, OptionError) else 3)


def test_nothing_steers_a_terminal() -> None:
    assert printable("Stück 3 m²") == "Stück 3 m²"
    assert printable("a\x1b[2J\x9b2J\nb\u202ec\udcff") == "a\\x1b[2J\\x9b2J\\nb\\u202ec\\udcff"
    assert printable("a\nb\x1b", "\n") == "a\nb\\x1b"
