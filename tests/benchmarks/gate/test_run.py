"""``benchmarks gate``: a row for each kind, kept for the next run; what is free by much is accepted."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.gate import run
from benchmarks.gate.report import Row
from benchmarks.gate.run import bench_gate
from benchmarks.results import read_rows


def test_rows_are_written_and_kept(tmp_path: Path) -> None:
    asked = {"chunks": 10, "attack": 12, "robots": ("planar_2r",), "steps": 4}
    rows = bench_gate(tmp_path, **asked).rows
    assert [row.kind for row in rows] == ["lines", "cubics", "quintics"]
    for row in rows:
        assert (row.tries, row.false, row.beyond) == (12, 0, 0)
        assert 0 < row.p50_ms <= row.p99_ms
        assert row.accepted_20 == row.free_20 <= row.free_5 <= row.chunks == 10
        assert row.change_ms > 0
        assert row.change_again_ms > 0
    assert sum(row.free_20 for row in rows)
    assert read_rows(tmp_path / "gate.csv", Row, "python -m benchmarks gate") == list(rows)
    assert bench_gate(tmp_path, **asked).rows == rows
    text = (tmp_path / "gate.md").read_text()
    assert "## Attacked" in text
    assert "p99 cpu ms" in text


def test_lines_are_put_to_hpp_too_where_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "proven_by_hpp", lambda python, gate, chunks: (4 * len(chunks), 0.5))
    rows = bench_gate(tmp_path, chunks=6, attack=0, robots=("planar_2r",), steps=4, python="elsewhere").rows
    assert rows[0].hpp_pieces == rows[0].hpp_proven
    assert rows[0].hpp_ms
    assert [row.hpp_ms for row in rows[1:]] == [None, None]
