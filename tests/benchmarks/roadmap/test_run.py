"""``benchmarks roadmap``: every method has its row, its peers are asked the same, and the aims are judged."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.results import read_rows
from benchmarks.roadmap import run as bench
from benchmarks.roadmap.report import (
    CHECKS,
    MEASURED,
    NOT_INSTALLED,
    OMPL,
    OMPL_PLAIN,
    OURS,
    PEERS,
    PLAN,
    PYROBOPLAN,
    Row,
)
from benchmarks.roadmap.run import METHODS, bench_roadmap
from planner.base.errors import OptionError, RobotError, SceneError
from planner.base.progress import QUIET, Progress
from planner.problem.request import WorldRequest


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> WorldRequest:
    """planar_2r beside a post: room enough for everybody."""
    scene = tmp_path_factory.mktemp("scene") / "post.yaml"
    scene.write_text("obstacles: [{name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}]\n")
    return WorldRequest("planar_2r", str(scene), collision="coal")


@pytest.fixture(scope="module")
def folder(world: WorldRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("roadmap")
    assert bench_roadmap(place, world, nodes=40, queries=4).complete
    return place


def rows_of(folder: Path) -> dict[str, Row]:
    return {row.method: row for row in read_rows(folder / "roadmap.csv", Row, "python -m benchmarks roadmap")}


def test_every_method_has_a_row(folder: Path) -> None:
    rows = rows_of(folder)
    assert set(rows) == {OURS, *PEERS, *CHECKS}
    ours, ompl, plain = rows[OURS], rows[OMPL], rows[OMPL_PLAIN]
    assert ours.outcome == ompl.outcome == plain.outcome == MEASURED
    assert ours.proven == ours.edges
    assert ours.touching == ours.contacts == 0
    assert ours.solved == ompl.solved == plain.solved == 4
    for row in (ours, ompl, plain):
        assert row.nodes is not None
        assert row.edges is not None
        assert 38 <= row.nodes <= 60
        assert row.edges >= 30
        assert row.looked_at == min(row.edges, 200)
        assert 0 < (row.query_ms or 0) <= (row.query_worst_ms or 0)
    assert (ours.many_ms or 0) > 0
    for name in CHECKS:
        row = rows[name]
        assert 0 < (row.check_edge_us or 0) < 1e5
    text = (folder / "roadmap.md").read_text()
    assert "| gabf-planner |" in text
    assert "| FCL checks |" in text


def test_what_is_not_installed_is_said(folder: Path) -> None:
    row = rows_of(folder)[PYROBOPLAN]
    if row.outcome == NOT_INSTALLED:
        assert "pip install --no-deps pyroboplan" in (folder / "roadmap.md").read_text()
    else:
        assert row.nodes == 40


def test_rows_that_are_there_are_not_measured_again(
    folder: Path, world: WorldRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda blank, stop: measured.append(blank.method) or [])
    again = bench_roadmap(folder, world, nodes=40, queries=4)
    assert (measured, again.complete, len(again.rows)) == ([], True, len(METHODS) + 1)
    assert not bench_roadmap(folder, world, nodes=41, queries=4).complete
    assert measured == [OURS]


def test_sizes_are_rows_of_ours_and_of_plans(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench, "METHODS", (OURS,))
    found = bench_roadmap(tmp_path, WorldRequest("planar_2r", "window", collision="coal"), 40, 2, sizes=(40, 80))
    assert [(row.method, row.nodes_asked) for row in found.rows] == [(OURS, 40), (PLAN, 40), (OURS, 80), (PLAN, 80)]
    assert {row.outcome for row in found.rows} == {MEASURED}
    for row in found.rows:
        assert (row.cpu_s or 0) > 0
        assert row.method == OURS or (row.plan_s or 0) > 0 < 20 < (row.memory_mib or 0)
    assert "Growth with the nodes, fitted: building n^" in found.report


def test_a_method_that_takes_too_long_is_killed(world: WorldRequest, tmp_path: Path) -> None:
    found = bench_roadmap(tmp_path, world, nodes=40, queries=1, time_limit=0.05)
    assert found.complete
    assert all(row.outcome == "timed out" for row in found.rows)
    assert "- OMPL PRM, our checker: timed out. Killed after 0.05 s." in (tmp_path / "roadmap.md").read_text()


def test_a_crash_is_a_row(tmp_path: Path) -> None:
    """OMPL's PRM is not compared on continuous joints, and says so."""
    blank = Row(OMPL, "kinova", "empty", "coal", 10, 1, 0, 60.0, "here", "crashed")
    row = bench._measure(blank, QUIET)[0]
    assert row.outcome == "crashed"
    assert "kinova has continuous joints" in row.message
    assert bench._measure(blank, Progress(stop=lambda: True)) == []


def row(method: str, **more) -> Row:
    plain = Row(method, "panda", "shelf", "coal", 1000, 20, 0, 600.0, "here", MEASURED, build_s=2.0, query_ms=20.0)
    return replace(plain, **{"nodes": 1000, "edges": 2000, "touching": 0, "looked_at": 200, "contacts": 0} | more)


def test_wrong_input(world: WorldRequest, tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="at least one query"):
        bench_roadmap(tmp_path, world, queries=0)
    with pytest.raises(RobotError, match="robots are"):
        bench_roadmap(tmp_path, WorldRequest("marvin", "shelf"))
    with pytest.raises(SceneError, match="scenes are"):
        bench_roadmap(tmp_path, WorldRequest("panda", "moon"))
    assert list(tmp_path.iterdir()) == []
