"""Which versions of written files are read."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from planner.base.errors import FileError
from planner.base.formats import FORMAT_VERSION, require_readable_version
from planner.planning.result import Plan
from tests.command_line import Run


@pytest.mark.parametrize("version", [FORMAT_VERSION + 1, 0, "1", None, True, 10**60])
def test_other_versions_are_refused_with_the_remedy(version: object) -> None:
    with pytest.raises(FileError, match="update the planner"):
        require_readable_version({"format_version": version}, "it")


def test_a_plan_of_an_older_planner_is_read_and_of_a_newer_one_refused(solved: Plan, tmp_path: Path, run: Run) -> None:
    record, path = solved.to_dict(), tmp_path / "plan.json"
    assert record.pop("format_version") == FORMAT_VERSION
    path.write_text(json.dumps(record))
    assert run("check", str(path), "--step", "0.1")[0] == 0
    path.write_text(json.dumps({**record, "format_version": FORMAT_VERSION + 1}))
    code, _, error = run("check", str(path))
    assert code == 3
    assert "update the planner" in error
