"""Text and paths in place of each other, and nothing else."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

import pytest

from planner.base.errors import FileError
from planner.base.places import place, place_text


def test_text_and_paths_are_places() -> None:
    for given in ("a/b", Path("a/b"), PurePosixPath("a/b")):
        assert place(given) == Path("a/b")
        assert place_text(given) == "a/b"
    assert place_text("./a") == "./a", "text may be a name: it stays"


@pytest.mark.parametrize("given", [None, 3, b"x", ["a"]])
def test_nothing_else_is(given: object) -> None:
    for read in (place, place_text):
        with pytest.raises(FileError, match=r"^limits is a \w+, no path: give text or a pathlib.Path\.$"):
            read(given, "limits")  # type: ignore[arg-type]
