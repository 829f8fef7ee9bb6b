"""What the benchmark of roadmaps says."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.roadmap.report import (
    OMPL,
    OURS,
    PYROBOPLAN,
    aims,
    to_markdown,
)
from tests.benchmarks.roadmap.test_run import row


def test_aims_are_met_and_missed() -> None:
    good = [row(OURS), row(OMPL, build_s=21.0), row(PYROBOPLAN, build_s=60.0)]
    assert [(aim.confirmed, aim.of) for aim in aims(good)] == [(2, 2), (1, 1), (1, 1), (0, 0), (0, 0)]
    assert "OMPL PRM, our checker: 10.5 times" in aims(good)[0].note
    bad = [replace(good[0], query_ms=51.0, touching=1), replace(good[1], build_s=19.0)]
    assert [aim.confirmed for aim in aims(bad)] == [0, 0, 0, 0, 0]
    assert [aim.of for aim in aims([])] == [0, 0, 0, 0, 0]
    text = to_markdown(good)
    assert "| OMPL PRM, our checker | 21 | 10.5 |" in text
    assert to_markdown([], complete=False).startswith("# python -m benchmarks roadmap")


def test_growth_is_fitted_and_judged() -> None:
    of = {nodes: replace(row(OURS), nodes_asked=nodes, touching=0, contacts=0) for nodes in (1000, 4000, 20_000)}
    rows = [
        replace(one, build_s=5e-4 * n**1.1, cpu_s=1e-3 * n**1.2, query_ms=n**0.5, method=OURS) for n, one in of.items()
    ]
    report = to_markdown(rows)
    assert "building n^1.10, its CPU time n^1.20, a query n^0.50" in report
    assert "- 1 of 1: The time to build grows at most as n^1.2. n^1.10" in report
    assert "- 1 of 1: 20000 proven nodes are there within 40 s. 26.9 s" in report
    assert not aims([replace(one, build_s=1e-6 * one.nodes_asked**2) for one in rows])[3].confirmed


def test_the_check_of_nodes_is_told_apart() -> None:
    ours = replace(row(OURS), build_s=0.3, node_checks_s=0.08, nodes=1000)
    assert (
        "0.080 s are the check of its nodes by coal, 0.080 ms a node; without it the build takes 0.220 s"
        in to_markdown([ours])
    )
    assert "check of its nodes" not in to_markdown([row(OMPL)])
