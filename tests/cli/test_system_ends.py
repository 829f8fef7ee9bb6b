"""A full disk, too little memory and names that the system refuses end in one sentence, not in a traceback."""

import errno
from collections.abc import Callable

import pytest

Run = Callable[..., tuple[int, str, str]]

ENDS = {
    "no memory": (MemoryError(), 3, "the memory is exhausted"),
    "a library": (ImportError("libx.so: failed to map segment"), 3, "a library cannot be loaded (libx.so"),
    "no thread": (RuntimeError("can't start new thread"), 3, "the memory is exhausted"),
    "a full disk": (OSError(errno.ENOSPC, "No space left on device"), 3, "No space left on device; free space"),
    "a closed pipe": (BrokenPipeError(), 0, ""),
}


@pytest.mark.parametrize("name", ENDS)
def test_errors_of_the_system_are_sentences(name: str, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    error, code, part = ENDS[name]

    def refuse(_: list[str]) -> int:
        raise error

    monkeypatch.setattr("planner.cli.app.run", refuse)
    got, out, err = run("robots")
    assert (got, out) == (code, "")
    assert part in err
    assert len(err.splitlines()) == bool(part)


def test_a_bug_is_no_system(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: list[str]) -> int:
        raise RuntimeError("a bug")

    monkeypatch.setattr("planner.cli.app.run", refuse)
    with pytest.raises(RuntimeError, match="a bug"):
        run("robots")
