"""What the benchmark of plans says."""

from __future__ import annotations

import pytest

from benchmarks.plan.report import aims, compare, to_markdown
from planner.batch.outcomes import NO_PATH, REFUSED, TIMED_OUT
from tests.benchmarks.plan.test_ompl_log import bare
from tests.benchmarks.plan.test_run import row


def test_the_report_counts() -> None:
    rows = [row(seed=k, total_s=1.0 + k, clearance_m=0.001 * (k + 1)) for k in range(4)]
    rows += [row(seed=4, total_s=11.0), bare(REFUSED, seed=5), bare(TIMED_OUT, seed=6), bare(NO_PATH, seed=7)]
    text = to_markdown(rows)
    line = next(line for line in text.splitlines() if line.startswith("| all "))
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells[:9] == ["all", "8", "1", "5", "71 %", "4", "1", "1", "0"]
    assert cells[9:11] == ["3", "9.6"]  # median and 95th percentile of 1, 2, 3, 4, 11
    assert cells[16:18] == ["3", "1"]
    assert "- posts/1, seed 5: refused: why" in text
    first = aims(rows)[0]
    assert (first.confirmed, first.of) == (4, 7)
    assert [aim.holds for aim in aims(rows)[1:]] == [True, True, True, True]
    assert to_markdown([]).startswith("# python -m benchmarks plan")


def test_aims_are_missed() -> None:
    bad = [row(contacts=1, contact="segment 0", certified=1999, first_path_s=0.6, total_s=5.1)]
    assert [aim.confirmed for aim in aims(bad)] == [1, 0, 0, 0, 0]
    assert "1 segments touch; segment 0" in to_markdown(bad)
    assert [aim.of for aim in aims([row(collision="fcl")])[3:]] == [0, 0]


def test_settings_are_compared_on_what_both_solved() -> None:
    base = [row(problem=f"p/{k}") for k in range(3)]
    low = [row(problem=f"p/{k}", beta=0.0, length_rad=4.0 * (1.1 + 0.1 * k), w_mean=0.09) for k in range(2)]
    low.append(bare(NO_PATH, problem="p/2", beta=0.0))
    other = [row(problem="p/0", beta=0.0, nodes_asked=500, collision="fcl")]
    table = [line for line in to_markdown([*low, *base, *other]).splitlines() if "against" in line or "beta" in line]
    assert any(
        line.startswith("| panda, coal, 1000 nodes, beta 0 | panda, coal, 1000 nodes, beta 1 | 2 | 1.15 |")
        for line in table
    )
    assert sum(line.startswith("| panda") for line in table) == 1  # fcl at 500 nodes differs in more than one point
    cells = compare("a", base, "b", low)
    assert cells[:3] == ["b", "a", 2]
    assert cells[3:7] == [pytest.approx(x) for x in (1.15, 1.0, 1.0, 1.5)]
    assert cells[8:] == [1, 0]
    # a floor and another beta at once are still set against length only
    floor = [row(problem="p/0", beta=0.0, options="min_manipulability 0.03")]
    assert "min_manipulability 0.03 | panda, coal, 1000 nodes, beta 1 |" in to_markdown([*base, *floor])
