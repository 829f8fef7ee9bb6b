"""Files of two runs side by side are noticed, by whichever of them one begins."""

from __future__ import annotations

import json
import logging
from pathlib import Path

import pytest

from planner.base.beside import hashes, mismatch, warn_of_mismatch


@pytest.fixture
def record(tmp_path: Path) -> Path:
    (tmp_path / "roadmap.npz").write_bytes(b"first")
    (tmp_path / "plan.html").write_bytes(b"page")
    files = hashes(tmp_path, ("roadmap.npz", "plan.html", "trajectory.json"))
    assert sorted(files) == ["plan.html", "roadmap.npz"]
    (tmp_path / "plan.json").write_text(json.dumps({"files": files}))
    return tmp_path / "plan.json"


def test_what_fits_says_nothing(record: Path) -> None:
    for name in ("plan.json", "roadmap.npz", "plan.html", "trajectory.json", "other.npz"):
        assert mismatch(record.with_name(name)) is None
    record.with_name("plan.html").unlink()
    assert mismatch(record) is None


def test_another_file_is_noticed_from_both_sides(record: Path, caplog: pytest.LogCaptureFixture) -> None:
    roadmap = record.with_name("roadmap.npz")
    roadmap.write_bytes(b"second")
    assert "was written with another roadmap.npz than stands beside it" in (mismatch(record) or "")
    assert "is not the one that plan.json beside it was written with" in (mismatch(roadmap) or "")
    assert mismatch(record.with_name("plan.html")) is None
    with caplog.at_level(logging.WARNING):
        warn_of_mismatch(roadmap)
        warn_of_mismatch(record.with_name("plan.html"))
    assert len(caplog.records) == 1


def test_a_roadmap_fits_where_one_of_two_records_has_it(record: Path) -> None:
    roadmap = record.with_name("roadmap.npz")
    roadmap.write_bytes(b"of a sweep")
    record.with_name("sweep.json").write_text(json.dumps({"files": hashes(record.parent, ("roadmap.npz",))}))
    assert mismatch(roadmap) is None
    assert mismatch(record) is not None


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[" * 100_000,
        "[]",
        '{"files": []}',
        '{"files": {"roadmap.npz": 1, "/dev/zero": "x", "../a": "x", "": "x", "a\\u0000": "x"}}',
    ],
)
def test_a_record_that_says_nothing_of_use_is_no_obstacle(record: Path, text: str) -> None:
    record.write_text(text)
    assert mismatch(record) is None
    assert mismatch(record.with_name("roadmap.npz")) is None
