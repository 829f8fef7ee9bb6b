"""``benchmarks agreement``: FCL and coal agree, and where a checker lies it is found out and explained or not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.agreement import run as bench
from benchmarks.agreement.contact_band import band
from benchmarks.agreement.report import Row, aims, to_markdown
from benchmarks.agreement.run import batch_differences, bench_agreement, verdicts
from benchmarks.results import read_rows
from planner.base.errors import OptionError, SceneError
from planner.base.progress import Progress
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.collision.world import Contact
from planner.models.poses import pose
from planner.models.scene import Scene
from planner.models.shapes import Obstacle, Sphere
from tests.coal_judge import CoalWorld
from tests.worlds import load, random_q


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("agreement")
    bench_agreement(place, states=160, scenes=("paper", "cage"), robots=("iiwa14", "panda"))
    return place


def test_the_two_libraries_agree(folder: Path) -> None:
    rows = read_rows(folder / "agreement.csv", Row, "python -m benchmarks agreement")
    assert [(row.robot, row.scene) for row in rows][:2] == [("iiwa14", "paper"), ("iiwa14", "cage")]
    assert len(rows) == 4
    for row in rows:
        assert row.states == 40
        assert 0 < row.free < 40
        assert row.disagreed == row.unexplained == row.batch_differs == 0, row.listed
        assert row.crossings > 5
        assert row.band_m <= band(0.0), row.listed
        for speed in (row.fcl_single, row.coal_single, row.fcl_batch, row.coal_batch):
            assert speed is not None
            assert 0 < speed < 1e5
    assert all(aim.holds for aim in aims(rows)[:2])
    assert "| iiwa14 | paper | 40 |" in (folder / "agreement.md").read_text()


def test_with_a_margin_the_band_is_wider_and_stated(tmp_path: Path) -> None:
    row = bench_agreement(tmp_path, states=60, scenes=("paper",), robots=("iiwa14",), margin=0.01).rows[0]
    assert row.disagreed == row.unexplained == row.batch_differs == 0, row.listed
    assert band(0.01) > band(0.0)
    assert row.band_m <= band(0.01)


def test_verdicts_are_coals_own_distances() -> None:
    """Against distances of all pairs by coal, at placements by Pinocchio."""
    fcl, coal = (make_checker(load("ur5"), Scene.load("window"), name) for name in ("fcl", "coal"))
    q = random_q(load("ur5"), 40, seed=3)
    by_fcl, by_coal = verdicts(fcl, coal, q) or (None, None)
    world = CoalWorld(fcl.world)
    truth = [world.distances(row).min() > 0 for row in q]
    assert by_fcl is not None
    assert by_coal is not None
    assert by_fcl.tolist() == by_coal.tolist() == truth
    assert verdicts(fcl, coal, q, progress=Progress(stop=lambda: True)) is None


def ball_of(radius: float) -> Scene:
    """A ball beside planar_2r, which touches it when the arm turns there."""
    return Scene("ball", (Obstacle("ball", Sphere(radius), pose([0.5, 0.5, 0.0])),))


def pair_of(fcl_radius: float = 0.1) -> tuple[CollisionChecker, CollisionChecker]:
    """FCL and coal; with another radius FCL sees a ball that is not the one that coal sees."""
    robot = load("planar_2r")
    return make_checker(robot, ball_of(fcl_radius), "fcl"), make_checker(robot, ball_of(0.1), "coal")


FREE, TOUCHING = np.array([-0.5, 0.0]), np.array([0.75, 0.0])


class Forgetful:
    """A checker that sees nothing when asked about more than one configuration."""

    def __init__(self, checker: CollisionChecker) -> None:
        self.inner = checker

    @property
    def bound(self) -> Forgetful:
        return self

    def looks_free(self, q: np.ndarray) -> bool:
        return len(q) > 1 or self.inner.bound.looks_free(q)

    def first_contact(self, q: np.ndarray) -> tuple[int, Contact] | None:
        return None if len(q) > 1 else self.inner.first_contact(q)


def test_a_library_that_changes_its_mind_in_batches_is_found() -> None:
    fcl, _ = pair_of()
    touching = np.array([TOUCHING, TOUCHING + 0.01])
    assert batch_differences(fcl, FREE[None], touching) == 0
    assert batch_differences(fcl, FREE[:0].reshape(0, 2), touching) == 0
    assert batch_differences(Forgetful(fcl), FREE[None], touching) == 2  # type: ignore[arg-type]


def test_it_goes_on_where_it_stopped(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda pair, *rest, **_: measured.append(pair))
    bench_agreement(folder, states=160, scenes=("paper", "cage"), robots=("iiwa14", "panda"))
    assert measured == []
    bench_agreement(folder, states=160, scenes=("paper", "cage"), robots=("iiwa14", "panda"), seed=1)
    assert measured == [("iiwa14", "paper")]


def test_a_stop_abandons_the_world_at_hand(tmp_path: Path) -> None:
    found = bench_agreement(
        tmp_path, states=10, robots=("planar_2r",), scenes=("empty",), progress=Progress(stop=lambda: True)
    )
    assert (found.rows, found.complete) == ((), False)
    assert "Interrupted" in (tmp_path / "agreement.md").read_text()


def test_wrong_input(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="too few for"):
        bench_agreement(tmp_path, states=5)
    with pytest.raises(OptionError, match="margin"):
        bench_agreement(tmp_path, states=1000, margin=-1.0)
    with pytest.raises(SceneError, match="scenes are"):
        bench_agreement(tmp_path, states=10, robots=("planar_2r",), scenes=("moon",))


def test_aims_are_met_and_missed(folder: Path) -> None:
    rows = read_rows(folder / "agreement.csv", Row, "python -m benchmarks agreement")
    quick = [replace(row, coal_batch=9.0, fcl_edge=44.0) for row in rows]
    assert all(aim.holds for aim in aims(quick))
    slow = [replace(row, coal_batch=11.0, fcl_edge=46.0, batch_differs=1, band_m=1e-4) for row in rows]
    assert not any(aim.confirmed for aim in aims(slow))
    assert [aim.of for aim in aims([])] == [0, 0, 0, 0]
    assert to_markdown([], complete=False).startswith("# python -m benchmarks agreement")
