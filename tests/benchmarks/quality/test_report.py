"""Ratios to RRTConnect."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.quality.report import Row, aims, to_markdown
from planner.batch.outcomes import SOLVED


def row(problem: str, method: str, settings: str = "", **more: float) -> Row:
    return Row(problem, method, settings, 0, "coal", 1.0, "", "", SOLVED, straight_rad=1.0, w_min=1.0, **more)  # type: ignore[arg-type]


def test_ratios_are_to_rrtconnect_on_the_same_problem() -> None:
    ours = "beta 1, effort 6, 40 nodes"
    rows = [
        row("a", "RRTConnect", length_rad=2.0, w_mean=1.0, corners=3, dips=False, cpu_s=1.0),
        row("b", "RRTConnect", length_rad=4.0, w_mean=1.0, corners=3, dips=False, cpu_s=1.0),
        row("a", "planner", ours, length_rad=1.8, w_mean=1.0, corners=1, dips=True, cpu_s=2.0),
        row("b", "planner", ours, length_rad=3.8, w_mean=1.0, corners=4, dips=True, cpu_s=2.0),
    ]
    line = next(line for line in to_markdown(rows).splitlines() if line.startswith("| planner"))
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells[:4] == [f"planner {ours}", "2", "2", "2.8"]
    assert cells[-4:] == ["0.925", "1", "1", "2"]
    short, turns, *_ = aims(rows)
    assert short.holds
    assert turns.holds
    assert not aims([*rows, replace(rows[2], corners=9), replace(rows[3], corners=9)])[1].holds
