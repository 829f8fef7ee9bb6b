"""``benchmarks misses``: nothing that the proof certifies touches, OMPL's rule is OMPL's, and misses are told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.misses import run as bench
from benchmarks.misses.report import Row
from benchmarks.misses.run import bench_misses, judge
from benchmarks.misses.thin_obstacles import thin_case
from benchmarks.results import read_rows
from planner.base.errors import OptionError, RobotError
from planner.base.progress import Progress
from planner.collision import make_checker
from planner.models.scene import Scene
from tests.worlds import load


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("misses")
    bench_misses(place, edges=8, robots=("planar_2r",), thicknesses=(1.0, 5.0))
    bench_misses(place, edges=5, robots=("ur5",), thicknesses=(2.0,))
    return place


def test_nothing_certified_touches(folder: Path) -> None:
    rows = read_rows(folder / "misses.csv", Row, "python -m benchmarks misses")
    assert len(rows) == 9
    for row in rows:
        assert row.fcl_missed == row.coal_missed == 0, row.found
        assert row.fcl_proven + row.touching + row.fcl_left_out == row.edges
        assert row.coal_proven + row.touching + row.coal_left_out == row.edges
    # the cases are worth their name: some touch, some do not, nearly all of those are certified, and OMPL's rule errs
    total = {
        name: sum(getattr(row, name) for row in rows) for name in ("edges", "touching", "fcl_proven", "ompl_missed")
    }
    assert 0.2 < total["touching"] / total["edges"] < 0.9
    assert total["fcl_proven"] > 0.85 * (total["edges"] - total["touching"])
    assert total["ompl_missed"] > 0


def test_the_same_seed_gives_the_same_rows(folder: Path, tmp_path: Path) -> None:
    again = bench_misses(tmp_path, edges=8, robots=("planar_2r",), thicknesses=(5.0,)).rows
    assert set(again) <= set(read_rows(folder / "misses.csv", Row, "python -m benchmarks misses"))
    one, two = (bench_misses(tmp_path, edges=2, robots=("planar_2r",), thicknesses=(1.0,), seed=s).rows for s in (0, 1))
    assert [row.looks for row in one] != [row.looks for row in two]


def test_a_stop_keeps_what_is_there(tmp_path: Path) -> None:
    found = bench_misses(
        tmp_path, edges=5, robots=("planar_2r",), thicknesses=(5.0,), progress=Progress(stop=lambda: True)
    )
    assert found.rows == ()
    assert not found.complete
    assert "Interrupted" in (tmp_path / "misses.md").read_text()


def test_a_prover_that_looks_away_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """The suite would see a miss: with proofs that call everything free, every touching edge is one."""
    robot = load("planar_2r")
    case = thin_case(make_checker(robot, Scene("empty"), "coal"), "wall", 0.003, np.random.default_rng(2))

    class Blind:
        def __init__(self, checker) -> None: ...

        def prove(self, start, delta):
            return type("Proofs", (), {"free": np.ones(len(start), dtype=bool)})

    honest = list(judge(robot, case, 5))
    assert any(one.touches["coal"] for one in honest)
    assert not any(one.missed("fcl") or one.missed("coal") for one in honest)
    monkeypatch.setattr(bench, "EdgeProver", Blind)
    blind = list(judge(robot, case, 5))
    assert [one.missed("fcl") for one in blind] == [one.touches["coal"] for one in honest]
    assert [one.missed("coal") for one in blind] == [one.touches["coal"] for one in honest]
    text = next(one for one in blind if one.missed("fcl")).describe()
    assert text["certified by"] == ["fcl", "coal"]
    assert "Box" in text["obstacles"][0]["shape"]


def test_wrong_input(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="at least 1 edge"):
        bench_misses(tmp_path, edges=0)
    with pytest.raises(OptionError, match="thicknesses"):
        bench_misses(tmp_path, thicknesses=(0.0,))
    with pytest.raises(RobotError, match="robots are"):
        bench_misses(tmp_path, robots=("marvin",))
    assert list(tmp_path.iterdir()) == []
