"""A script run by another Python: what it gets, what comes back, and the libraries that its modules find."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from benchmarks.elsewhere import answer_of
from planner.base.errors import PlannerError

SAYS = """
import json, os, sys
*words, problem, answer = sys.argv[1:]
found = {"words": words, "asked": json.load(open(problem)), "libraries": os.environ.get("LD_LIBRARY_PATH")}
json.dump(found, open(answer, "w"))
"""


def environment(folder: Path) -> Path:
    """The Python of an environment with cmeel's libraries."""
    (folder / "bin").mkdir()
    (folder / "lib" / "python3.99" / "site-packages" / "cmeel.prefix" / "lib").mkdir(parents=True)
    (folder / "bin" / "python").symlink_to(sys.executable)
    return folder / "bin" / "python"


@pytest.mark.parametrize("before", [None, "/somewhere"])
def test_libraries_of_its_own_environment_come_first(
    before: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("LD_LIBRARY_PATH", raising=False)
    if before:
        monkeypatch.setenv("LD_LIBRARY_PATH", before)
    script = tmp_path / "script.py"
    script.write_text(SAYS)
    own = str(tmp_path / "lib" / "python3.99" / "site-packages" / "cmeel.prefix" / "lib")
    found = answer_of("hpp", str(environment(tmp_path)), str(script), {"a": 1}, 30.0, ["x"])
    assert found == {"words": ["x"], "asked": {"a": 1}, "libraries": f"{own}:{before}" if before else own}
    bare = tmp_path / "bare" / "bin" / "python"
    bare.parent.mkdir(parents=True)
    bare.symlink_to(sys.executable)
    plain = answer_of("hpp", str(bare), str(script), {}, 30.0)
    assert (plain["words"], plain["libraries"]) == ([], before)
    assert os.environ.get("LD_LIBRARY_PATH") == before


def test_a_script_that_fails_is_said_in_its_last_words(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text("raise ValueError('no robot')")
    with pytest.raises(PlannerError, match=r"hpp in .*: ValueError: no robot"):
        answer_of("hpp", sys.executable, str(tmp_path / "script.py"), {}, 30.0)
