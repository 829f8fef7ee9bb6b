"""What the benchmark of replanning says."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.replan.report import Row, aims, to_markdown

PLAIN = Row("a/1", "panda", "coal", 100, 0, 4, 5, "", "here", 1, "blocking the route", "solved", seconds=0.1, error=0.0)


def test_aims_are_judged_by_what_was_measured() -> None:
    slow = [replace(PLAIN, seconds=0.2, anew_s=1.0, contacts=1, error=1e-3)]
    touched = replace(PLAIN, kind="simulated", seconds=None, error=None, runs=5, touched_before=1, horizon=1.0)
    assert [aim.confirmed for aim in aims([*slow, touched])] == [0, 0, 0, 0, 0]
    fast = [replace(PLAIN, anew_s=1.0, contacts=0), replace(touched, touched_before=0, touched_after=2)]
    assert [aim.confirmed for aim in aims(fast)] == [1, 1, 1, 1, 1]
    assert "5 runs, 0 contacts before it and 2 after it" in to_markdown(fast)
    refused = replace(PLAIN, outcome="refused", seconds=None, message="no such thing.")
    assert "refused. no such thing." in to_markdown([refused])


def test_the_memory_of_long_sessions_is_told() -> None:
    rows = [replace(PLAIN, changes=1000, number=k, memory_mib=100.0 + k) for k in range(20)]
    assert "held 102 MiB after a tenth of them, 119 MiB after the last, 119 MiB at most" in to_markdown(rows)
    assert "MiB" not in to_markdown([replace(row, changes=100) for row in rows])
