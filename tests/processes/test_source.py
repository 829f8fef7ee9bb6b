"""The hash of the source: another one wherever a measurement may change, the same where results are only shown."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.base.versions import __version__
from planner.processes import source
from planner.processes.source import software, source_hash

MEASURED = ("planning.py", "gabf/solve.py", "native/source/ik.cpp", "native/source/ik.hpp", "batch/results.py")
SHOWN = ("cli/plan.py", "view/page.py", "view/figures/space.py")
NO_SOURCE = ("view/page.js", "gabf/solve.pyc", "README.md")


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of a few files in place of this one."""
    for name in (*MEASURED, *SHOWN, *NO_SOURCE):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    monkeypatch.setattr(source, "_PACKAGE", tmp_path)
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


def test_another_folder_counts_too_and_all_of_it(package: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    more = tmp_path_factory.mktemp("more")
    (more / "cli").mkdir()
    (more / "cli" / "run.py").write_text("1")
    before = source_hash.__wrapped__(more)
    assert before != source_hash.__wrapped__()
    (more / "cli" / "run.py").write_text("2")
    assert source_hash.__wrapped__(more) != before


def test_the_folders_that_are_left_out_are_there() -> None:
    assert source_hash() == source_hash.__wrapped__()
    assert all((source._PACKAGE / folder).is_dir() for folder in source._SILENT)


def test_software_names_versions_and_the_source() -> None:
    assert f"gabf-planner {__version__}" in software()
    assert f"source {source_hash()} on " in software()
