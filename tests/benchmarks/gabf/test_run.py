"""``benchmarks gabf``: rows, resuming, the table, the aims; sizes small enough for a test."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from benchmarks.gabf import run as bench
from benchmarks.gabf.report import Row
from benchmarks.gabf.run import bench_gabf
from benchmarks.results import read_rows
from planner.base.errors import FileError, OptionError, PlannerError
from planner.base.progress import Progress


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("bench")
    bench_gabf(place, sizes=(60, 120), rk45_up_to=60)
    return place


def test_every_method_has_a_row(folder: Path) -> None:
    rows = read_rows(folder / "gabf.csv", Row, "python -m benchmarks gabf")
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
    assert (folder / "gabf.md").read_text().startswith("# python -m benchmarks gabf")


def test_rows_that_are_there_are_not_measured_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda nodes, *rest, **_: measured.append(nodes))
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
    monkeypatch.setattr(bench, "software", lambda: "another numpy")
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda nodes, *rest, **_: measured.append(nodes))
    bench_gabf(folder, sizes=(60,), rk45_up_to=0)
    assert measured == [60]


def test_a_stop_abandons_the_size_at_hand(tmp_path: Path) -> None:
    found = bench_gabf(tmp_path, sizes=(60, 120), rk45_up_to=0, progress=Progress(stop=lambda: True))
    assert not found.complete
    assert found.rows == ()


def test_a_failing_measurement_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench, "write_network", lambda network, path: path.write_bytes(b"no network"))
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
