"""``planner bench gabf``: rows, resuming, the table, the aims; sizes small enough for a test."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import FileError, OptionError, PlannerError
from planner.base.progress import Progress
from planner.studies.bench_gabf import run as bench
from planner.studies.bench_gabf.case import geometric_network, load_network, measure, save_network
from planner.studies.bench_gabf.report import Row, aims, growth_exponents, to_markdown
from planner.studies.bench_gabf.run import bench_gabf
from planner.studies.process import peak_memory
from planner.studies.table import read_rows


def row(method: str, nodes: int, seconds: float, **more) -> Row:
    plain = Row(method, nodes, 10 * nodes, 8, 0, seconds, 3, 1.0, 1.0, 0.0, 40, 12.0, 50.0, 60.0, "here")
    return replace(plain, **more)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("bench")
    bench_gabf(place, sizes=(60, 120), rk45_up_to=60)
    return place


def test_every_method_has_a_row(folder: Path) -> None:
    rows = read_rows(folder / "gabf.csv", Row, "planner bench gabf")
    methods = [(r.nodes, r.method) for r in rows]
    assert sorted(methods) == sorted(
        [(60, "dijkstra"), (60, "gabf"), (60, "rk45 in tau"), (60, "rk45 in t"), (120, "dijkstra"), (120, "gabf")]
    )
    for r in rows:
        assert r.seconds > 0
        assert r.error < 1e-3
        assert r.over_gabf == pytest.approx(
            r.seconds / next(g.seconds for g in rows if (g.nodes, g.method) == (r.nodes, "gabf"))
        )
    assert all(r.error < 1e-12 for r in rows if r.method == "gabf")
    assert (folder / "gabf.md").read_text().startswith("# planner bench gabf")


def test_rows_that_are_there_are_not_measured_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda nodes, *rest: measured.append(nodes))
    again = bench_gabf(folder, sizes=(60, 120), rk45_up_to=60)
    assert measured == []
    assert again.complete
    assert len(again.rows) == 6
    # other neighbours, another seed, or RK45 where there was none: measured anew
    for change in ({"neighbours": 7}, {"seed": 1}, {"rk45_up_to": 120}):
        measured.clear()
        options: Any = {"sizes": (120,), "rk45_up_to": 60} | change
        bench_gabf(folder, **options)
        assert measured == [120]


def test_other_software_is_measured_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench, "_software", lambda: "another numpy")
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda nodes, *rest: measured.append(nodes))
    bench_gabf(folder, sizes=(60,), rk45_up_to=0)
    assert measured == [60]


def test_a_stop_abandons_the_size_at_hand(tmp_path: Path) -> None:
    found = bench_gabf(tmp_path, sizes=(60, 120), rk45_up_to=0, progress=Progress(stop=lambda: True))
    assert not found.complete
    assert found.rows == ()


def test_a_failing_measurement_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench, "save_network", lambda network, path: path.write_bytes(b"no network"))
    with pytest.raises(PlannerError, match="the measurement ended with code 1"):
        bench_gabf(tmp_path, sizes=(60,), rk45_up_to=0)


def test_a_foreign_table_is_refused(tmp_path: Path) -> None:
    (tmp_path / "gabf.csv").write_text("a,b\n1,2\n")
    with pytest.raises(FileError, match="move it away"):
        bench_gabf(tmp_path, sizes=(60,))


def test_impossible_sizes_are_refused(tmp_path: Path) -> None:
    wrong: Any
    for wrong in ({"sizes": (5,)}, {"sizes": (60,), "neighbours": 60}, {"sizes": (60,), "neighbours": 0}):
        with pytest.raises(OptionError):
            bench_gabf(tmp_path, **wrong)


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
    assert to_markdown([]).startswith("# planner")


def test_the_network_survives_its_file(tmp_path: Path) -> None:
    network = geometric_network(200, 8, np.random.default_rng(0))
    save_network(network, tmp_path / "n.npz")
    back = load_network(tmp_path / "n.npz")
    assert np.array_equal(back.indices, network.indices)
    assert np.array_equal(gabf.oracle(back), gabf.oracle(network))
    assert 8.0 <= network.n_arcs / network.n_nodes <= 11.0
    pairs = set(zip(network.tails.tolist(), network.indices.tolist(), strict=True))
    assert all((j, i) in pairs for i, j in pairs)


def test_measuring_counts_memory_and_every_run() -> None:
    found = measure(geometric_network(80, 6, np.random.default_rng(1)), repeats=2, rk45_repeats=1)
    repeats = {timing["method"]: timing["repeats"] for timing in found["timings"]}
    assert repeats == {"dijkstra": 2, "gabf": 2, "rk45 in tau": 1, "rk45 in t": 1}
    assert found["settled"]
    assert 1.0 < peak_memory() < 1e6
