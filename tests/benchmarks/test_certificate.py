"""``benchmarks certificate``: plans are certified, and false certificates counted."""

from __future__ import annotations

from pathlib import Path

from benchmarks.certificate.run import bench_certificate


def test_plans_are_certified_and_changes_counted(tmp_path: Path) -> None:
    found = bench_certificate(tmp_path, 50, ("planar_2r",), ("empty",))
    assert [row.verdict for row in found.rows] == ["proven"]
    assert (found.attack.changed, found.attack.false, found.complete) == (50, (), True)
    assert 0 < sum(accepted for _, accepted in found.attack.counts.values()) < 50
    assert found.attack.counts["witnesses climbed to more than there is"] == (1, 0)
    assert "0 of them false" in (tmp_path / "certificate.md").read_text()
    lines = (tmp_path / "changes.jsonl").read_text().splitlines()
    (tmp_path / "changes.jsonl").write_text(lines[0] + "\n")
    assert bench_certificate(tmp_path, 50, ("planar_2r",), ("empty",)).attack == found.attack, "it goes on"
    assert (tmp_path / "changes.jsonl").read_text().splitlines() == lines
