"""``benchmarks attack``: nothing claims too much, and what does is found; the worst that was found stays mended."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.attack.claims import attack_claims
from benchmarks.attack.report import Row, aims
from benchmarks.attack.run import PAIRS, bench_attack
from benchmarks.results import read_rows
from planner.base.errors import OptionError, RobotError
from planner.base.progress import QUIET, Progress
from planner.collision import BACKENDS


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("attack")
    bench_attack(place, tries=12, segments=2, robots=("planar_2r",))
    return place


def test_nothing_claims_too_much(folder: Path) -> None:
    rows = read_rows(folder / "attack.csv", Row, "python -m benchmarks attack")
    assert {(row.first, row.second, row.library) for row in rows if row.attack == "claims"} == {
        (*pair, library) for pair in PAIRS for library in BACKENDS
    }
    assert len(rows) == 2 * len(PAIRS) + 2 * (len(PAIRS) + 1) + 1
    for aim in aims(rows):
        assert aim.confirmed == aim.of > 0, aim.sentence
    apart, tried = (sum(getattr(row, name) for row in rows if row.attack == "claims") for name in ("apart", "tried"))
    assert 0.5 < apart / tried < 1.0  # or it would say little
    assert sum(row.free or 0 for row in rows) > 10


def test_the_same_seed_gives_the_same_rows_and_those_are_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = read_rows(folder / "attack.csv", Row, "python -m benchmarks attack")
    monkeypatch.setattr("benchmarks.attack.run._measure", lambda *_, **__: pytest.fail("measured again"))
    assert bench_attack(folder, tries=12, segments=2, robots=("planar_2r",)).rows == tuple(before)
    worst = [attack_claims(("box", "capsule"), "fcl", 12, np.random.default_rng(5), QUIET) for _ in range(2)]
    assert worst[0] == worst[1]


def test_a_stop_keeps_what_is_there(tmp_path: Path) -> None:
    found = bench_attack(tmp_path, tries=12, segments=2, progress=Progress(stop=lambda: True))
    assert found.rows == ()
    assert not found.complete
    assert "Interrupted" in (tmp_path / "attack.md").read_text()


def test_wrong_input(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="at least 1 try"):
        bench_attack(tmp_path, tries=0)
    with pytest.raises(RobotError, match="marvin"):
        bench_attack(tmp_path, robots=("marvin",))


# claims that are wrong are found: FCL as it measures meshes itself, bounds and a reach that are a little too large


# the worst that was found: two shapes where they stand, and the distance (m) that FCL reports of them
