"""The hash of the source: another one wherever a measurement may change, the same where results are only shown."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.studies import source
from planner.studies.source import source_hash

MEASURED = ("planning.py", "gabf/solve.py", "native/source/ik.cpp", "native/source/ik.hpp", "studies/table.py")
SHOWN = ("cli/plan.py", "view/page.py", "figures/space.py", "studies/laws/run.py", "studies/learning/run.py")
NO_SOURCE = ("view/page.js", "gabf/solve.pyc", "README.md")


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of a few files in place of this one."""
    for name in (*MEASURED, *SHOWN, *NO_SOURCE):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    monkeypatch.setattr(source, "__file__", str(tmp_path / "studies" / "source.py"))
    return tmp_path


@pytest.mark.parametrize("name", MEASURED)
def test_source_that_decides_a_measurement_changes_it(package: Path, name: str) -> None:
    before = source_hash.__wrapped__()
    (package / name).write_text("changed")
    changed = source_hash.__wrapped__()
    (package / name).rename(package / "renamed.py")
    assert len({before, changed, source_hash.__wrapped__()}) == 3


@pytest.mark.parametrize("name", [*SHOWN, *NO_SOURCE])
def test_what_only_shows_results_does_not(package: Path, name: str) -> None:
    before = source_hash.__wrapped__()
    (package / name).write_text("changed")
    assert source_hash.__wrapped__() == before


def test_the_folders_that_are_left_out_are_there() -> None:
    assert source_hash() == source_hash.__wrapped__()
    package = Path(source.__file__).resolve().parents[1]
    assert all((package / folder).is_dir() for folder in source._SILENT)
