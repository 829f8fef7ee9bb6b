"""What the benchmark of first paths says."""

from __future__ import annotations

from benchmarks.first_path.report import OMPL, OURS, Row, to_markdown
from planner.batch.outcomes import SOLVED


def test_the_report_counts_paths_that_touch() -> None:
    def row(problem: str, method: str, **more: float) -> Row:
        return Row(problem, method, 0, "panda", "coal", 1.0, "", "", SOLVED, "here", first_s=0.1, path_s=0.2, **more)  # type: ignore[arg-type]

    report = to_markdown([row("a", OURS, contacts=0), row("a", OMPL, contacts=3), row("b", OMPL, contacts=0)])
    assert "| planner | 1 | 1 |" in report
    assert "| 1 of 2 | none |" in report
    assert "- 1 of 1: No path of ours touches anything." in report
    assert "- 0 of 1: Our first proven path" in report
    assert "a, OMPL RRTConnect, plain coal touches: here." in report
