"""The form of a refusal of a file."""

from collections.abc import Callable

import pytest

from planner.base.errors import PlannerError


def refusal_of(load: Callable[[], object]) -> str:
    """The one sentence with which ``load`` refuses."""
    with pytest.raises(PlannerError) as caught:
        load()
    text = str(caught.value)
    assert caught.value.exit_code == 3
    assert text.endswith(".")
    assert "\n" not in text
    assert len(text) < 1000
    return text
