"""Text that people write: read, parsed without constructing objects, and checked against a model."""

from __future__ import annotations

import pytest

from planner.base.errors import FileError, PlannerError, SceneError
from planner.base.yamlfile import parse_yaml, shown
from planner.world.scene import Scene


def test_what_has_no_end_is_not_read_to_its_end() -> None:
    with pytest.raises(FileError, match="larger than 256 MiB"):
        Scene.load("/dev/zero")


def test_whatever_is_quoted_is_short() -> None:
    assert shown("a.b") == "'a.b'"
    assert len(shown("x" * 10_000)) < 200
    assert len(shown([["x" * 100] * 100] * 100)) < 2000
    assert "thousands of digits" in shown(1 << 100_000)
    with pytest.raises(FileError):
        parse_yaml("!!timestamp x", "it")
    assert issubclass(SceneError, PlannerError)
