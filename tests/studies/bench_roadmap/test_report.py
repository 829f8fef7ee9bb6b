"""What the benchmark of roadmaps says."""

from __future__ import annotations

from dataclasses import replace

from planner.studies.bench_roadmap.report import (
    OMPL,
    OURS,
    PYROBOPLAN,
    aims,
    to_markdown,
)
from tests.studies.bench_roadmap.test_run import row


def test_aims_are_met_and_missed() -> None:
    good = [row(OURS), row(OMPL, build_s=21.0), row(PYROBOPLAN, build_s=60.0)]
    assert [(aim.confirmed, aim.of) for aim in aims(good)] == [(2, 2), (1, 1), (1, 1)]
    assert "OMPL PRM, our checker: 10.5 times" in aims(good)[0].note
    bad = [replace(good[0], query_ms=51.0, touching=1), replace(good[1], build_s=19.0)]
    assert [aim.confirmed for aim in aims(bad)] == [0, 0, 0]
    assert [aim.of for aim in aims([])] == [0, 0, 0]
    text = to_markdown(good)
    assert "| OMPL PRM, our checker | 21 | 10.5 |" in text
    assert to_markdown([], complete=False).startswith("# planner bench roadmap")
