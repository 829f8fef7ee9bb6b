"""What the benchmark of the dynamics says."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.gabf.report import Row, aims, growth_exponents, to_markdown


def row(method: str, nodes: int, seconds: float, **more) -> Row:
    plain = Row(method, nodes, 10 * nodes, 8, 0, seconds, 3, 1.0, 1.0, 0.0, 40, 12.0, 50.0, 60.0, "here")
    return replace(plain, **more)


def test_growth_is_the_slope_in_logarithms() -> None:
    rows = [row("gabf", n, 1e-6 * n**1.25) for n in (1000, 10_000, 100_000)] + [row("dijkstra", 1000, 1.0)]
    assert growth_exponents(rows) == {"gabf": pytest.approx(1.25)}


def test_aims_are_met_and_missed() -> None:
    good = [
        row("gabf", 1000, 0.01, over_dijkstra=50.0),
        row("rk45 in tau", 1000, 0.7, over_gabf=70.0, error=1e-5),
        row("gabf", 100_000, 2.0, over_dijkstra=55.0),
        row("gabf", 1_000_000, 40.0, memory_peak_mib=2500.0),
    ]
    assert all(aim.holds for aim in aims(good))
    bad = [replace(r, over_dijkstra=61.0, over_gabf=59.0, memory_peak_mib=3100.0) for r in good]
    assert not any(aim.confirmed for aim in aims(bad))
    more_exact = [replace(r, error=1e-15) if r.method != "gabf" else replace(r, error=1e-9) for r in good]
    assert aims(more_exact)[0].confirmed == 0
    assert [aim.of for aim in aims([])] == [0, 0, 0]


def test_the_table_has_a_line_a_size() -> None:
    rows = [row(m, n, 0.1) for n in (1000, 10_000) for m in ("gabf", "dijkstra")] + [row("rk45 in tau", 1000, 2.0)]
    text = to_markdown(rows)
    lines = [line for line in text.splitlines() if line.startswith("|")]
    assert len(lines) == 4
    assert len({line.count("|") for line in lines}) == 1
    assert "Limitations" in text
    assert to_markdown([]).startswith("# python -m benchmarks gabf")
