"""The common shape of a report, and that it is written whole."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import FileError
from planner.base.tables import text_table
from planner.reproduce import report as reports
from planner.reproduce.report import Report, Verdict, require_figures, spread, tally, write_report


class Dot:
    """The least that can save itself as a picture."""

    def savefig(self, fname, **options) -> None:
        assert options["format"] == "png"
        fname.write(b"\x89PNG")


class Torn:
    """A picture that fails to draw."""

    def savefig(self, fname, **options) -> None:
        raise RuntimeError("no ink")


def small(**more) -> Report:
    rows = ({"node": 1, "x": np.inf, "u": np.float64(0.25), "k": np.int64(3)},)
    return Report("toy", {"seed": 0}, rows, (Verdict("It holds.", 2, 3, "twice"),), **more)


def test_a_report_is_written_with_its_figures(tmp_path: Path) -> None:
    paths = write_report(small(figures={"dot.png": Dot()}, more={"extra": [1, 2]}), tmp_path / "new")
    record = json.loads((tmp_path / "new" / "toy.json").read_text())
    assert [path.name for path in paths] == ["dot.png", "toy.json"]
    assert (tmp_path / "new" / "dot.png").read_bytes() == b"\x89PNG"
    assert record["verdicts"] == [{"sentence": "It holds.", "confirmed": 2, "of": 3, "note": "twice"}]
    assert record["table"] == [{"node": 1, "x": None, "u": 0.25, "k": 3}]
    assert record["figures"] == ["dot.png"]
    assert record["extra"] == [1, 2]
    assert record["complete"] is True
    assert set(record["versions"]) == {"python", "gabf-planner", "numpy", "scipy"}


def test_a_failure_leaves_the_old_report_and_no_scrap(tmp_path: Path) -> None:
    write_report(small(), tmp_path)
    before = (tmp_path / "toy.json").read_bytes()
    with pytest.raises(RuntimeError):
        write_report(small(figures={"torn.png": Torn()}, complete=False), tmp_path)
    assert (tmp_path / "toy.json").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["toy.json"]


def test_a_folder_that_cannot_be_made_is_an_error_with_a_remedy(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="choose another place"):
        write_report(small(), tmp_path / "file" / "below")


def test_a_verdict_holds_only_if_every_case_did() -> None:
    assert tally("s", [True, True], "").holds
    assert not tally("s", [True, False], "").holds
    assert not tally("s", [], "").holds
    assert tally("s", [True, False, True], "") == Verdict("s", 2, 3, "")


def test_spread_and_text_table() -> None:
    assert spread([1.0, 3.0, 2.0]) == "2 (1 to 3)"
    assert spread([]) == "none"
    header, cells = text_table([{"a": 1, "b": 0.123456, "c": None}])
    assert (header, cells) == (["a", "b", "c"], [["1", "0.12346", "-"]])
    assert text_table([]) == ([], [])


def test_without_matplotlib_the_work_is_refused_before_it_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reports.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(FileError, match="pip install"):
        require_figures()
