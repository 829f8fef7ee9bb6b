"""``benchmarks certificate``: plans are certified, and false certificates counted."""

from __future__ import annotations

from pathlib import Path

from benchmarks.certificate.run import bench_certificate


def test_plans_are_certified_and_changes_counted(tmp_path: Path) -> None:
    found = bench_certificate(tmp_path, 40, ("planar_2r",), ("empty",))
    assert [row.verdict for row in found.rows] == ["proven"]
    assert (found.changed, found.false, found.complete) == (40, (), True)
    assert 0 < found.accepted < 40
    assert "0 of them false" in (tmp_path / "certificate.md").read_text()
