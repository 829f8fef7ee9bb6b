"""Errors end a command with 2 or 3, and name the choices."""

import pytest

from planner.base import errors
from planner.base.errors import OptionError, PlannerError, choices

KINDS = [kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, PlannerError)]


@pytest.mark.parametrize("kind", KINDS)
def test_only_a_wrong_option_is_2(kind: type[PlannerError]) -> None:
    assert kind.exit_code == (2 if issubclass(kind, OptionError) else 3)


def test_choices_stay_readable() -> None:
    assert choices(["a", "b"]) == "a, b"
    assert choices([]) == "none"
    assert len(choices(["x" * 1000, "b"])) == 203
    assert choices(map(str, range(100_000))).endswith("48, 49 and 99950 more")
