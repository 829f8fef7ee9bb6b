"""``planner bench attack``: nothing claims too much, and what does is found; the worst that was found stays mended."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import fcl
import numpy as np
import pytest

from planner.base.errors import OptionError, RobotError
from planner.base.progress import QUIET, Progress
from planner.collision import BACKENDS
from planner.collision.bounds import ClearanceBound
from planner.collision.coal import CoalChecker
from planner.collision.fcl import FclChecker, _geometry
from planner.kinematics.reach import Reach
from planner.native.library import NativeWorld
from planner.studies.bench_attack.cases import KINDS, Case, random_case
from planner.studies.bench_attack.claims import attack_claims, claims, world_of
from planner.studies.bench_attack.reach import attack_reach
from planner.studies.bench_attack.report import Row, aims, to_markdown
from planner.studies.bench_attack.run import PAIRS, bench_attack
from planner.studies.bench_attack.segments import attack_segments
from planner.studies.bench_attack.true_distance import true_distance
from planner.studies.table import read_rows
from planner.world.poses import pose
from planner.world.shapes import Box, Capsule, Mesh, Shape
from tests.worlds import load


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("attack")
    bench_attack(place, tries=12, segments=2, robots=("planar_2r",))
    return place


def test_nothing_claims_too_much(folder: Path) -> None:
    rows = read_rows(folder / "attack.csv", Row, "planner bench attack")
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
    before = read_rows(folder / "attack.csv", Row, "planner bench attack")
    monkeypatch.setattr("planner.studies.bench_attack.run._measure", None)  # nothing is measured again
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


@pytest.mark.parametrize("kind", KINDS)
def test_the_climb_keeps_shapes_and_placements_usable(kind: str) -> None:
    rng, case = np.random.default_rng(1), None
    for _ in range(60):
        case = random_case((kind, "mesh"), "distances", rng)
        for place in (case.place_first, case.place_second):
            np.testing.assert_allclose(place[:3, :3] @ place[:3, :3].T, np.eye(3), atol=1e-9)
    assert isinstance(json.dumps(case.describe()), str) if case else False


# claims that are wrong are found: FCL as it measures meshes itself, bounds and a reach that are a little too large


def believed(self: FclChecker, pair: int, rotation: np.ndarray, position: np.ndarray) -> float:
    """FCL's own distance of a mesh, as it was once believed."""
    first, second = self.world.members(pair)
    is_scene = self.world.is_scene_pair(pair)
    other = self._obstacles[second] if is_scene else self._moved(second, rotation, position)
    gap = fcl.distance(self._moved(first, rotation, position), other, fcl.DistanceRequest(), fcl.DistanceResult())
    return gap if gap > 1e-12 else -1.0


def test_fcls_own_distances_of_meshes_are_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FclChecker, "_distance", believed)
    worst = attack_claims(("cylinder", "mesh"), "fcl", 96, np.random.default_rng(0), QUIET)
    assert worst is not None
    assert worst.over["distances"] > 1e-4
    assert worst.beyond > 1e-4
    assert "Mesh" in json.dumps(worst.found["distances"])


def test_a_bound_that_is_too_large_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    honest = ClearanceBound.coarse
    monkeypatch.setattr(ClearanceBound, "coarse", lambda self, *placed: honest(self, *placed) + 1e-6)
    worst = attack_claims(("sphere", "box"), "coal", 48, np.random.default_rng(0), QUIET)
    assert worst is not None
    assert worst.beyond > 5e-7


def test_a_verdict_that_is_too_kind_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CoalChecker, "first_contact", lambda self, q: None)
    worst = attack_claims(("sphere", "sphere"), "coal", 96, np.random.default_rng(0), QUIET)
    assert worst is not None
    assert worst.over["verdict"] > 1e-5


def test_a_prover_that_looks_away_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    honest = NativeWorld.prove
    monkeypatch.setattr(NativeWorld, "prove", lambda self, reach, *asked: honest(self, 0.3 * reach, *asked))
    proven = attack_segments(("box", "sphere"), "fcl", 24, np.random.default_rng(0), QUIET)
    assert proven is not None
    assert proven.false_free > 0
    assert proven.found is not None
    assert proven.over > 1e-3


def test_a_reach_that_is_too_short_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    honest = Reach.motion
    monkeypatch.setattr(Reach, "motion", lambda self, delta: 0.98 * honest(self, delta))
    moved = attack_reach("planar_2r", 240, np.random.default_rng(0), QUIET)
    assert moved is not None
    assert moved.share > 1.0
    assert moved.over > 1e-6


def test_what_is_broken_is_in_the_report() -> None:
    empty = dict.fromkeys(Row.__annotations__)
    asked = {
        "attack": "segments",
        "first": "box",
        "second": "mesh",
        "library": "fcl",
        "tries": 5,
        "seed": 0,
        "tried": 5,
    }
    row = Row(**{**empty, **asked, "free": 3, "false_free": 1, "clearance_m": 2e-3, "found": "HERE", "software": "s"})
    text = to_markdown([row])
    assert "0 of 1: No segment that is called free touches" in text
    assert "HERE" in text
    assert "HERE" not in to_markdown([replace(row, false_free=0, clearance_m=-1e-3)])


# the worst that was found: two shapes where they stand, and the distance (m) that FCL reports of them

WORST_CLAIMS: list[tuple[Shape, np.ndarray, Shape, np.ndarray, float]] = [
    (
        Mesh(np.array([[0.0, 0, 0], [1.58, 0, 0], [1.11, 0.79, 0]]), np.array([[0, 1, 2]])),
        pose([0, 0, 0], [1.6, 0.9, 1.9]),
        Mesh(np.array([[0.0, 0, 0], [0.79, 0, 0], [0, 1.58, 0]]), np.array([[0, 1, 2]])),
        pose([0.71, -1.34, -1.54], [1.6, 0.9, 1.9]),
        2.1437,
    ),
    (
        Box((0.0218, 0.00676, 0.007778)),
        np.eye(4),
        Mesh(
            np.array([[-0.3294, -0.1404, 0], [0.3286, -0.1131, 0], [0.3286, 0.1131, 0.206], [-0.346, 0.1131, 0]]),
            np.array([[0, 1, 2], [0, 2, 3]]),
        ),
        pose([-0.14732, -0.04787, 0.31092], [-2.887494, -1.063389, 2.775205]),
        0.0185258,
    ),
    (
        Mesh(
            np.array([[-0.0076, -0.633, 0.0011], [0.0076, -0.635, 0], [0.0077, 0.634, 0.2168], [-0.0076, 0.634, 0]]),
            np.array([[0, 1, 2], [0, 2, 3]]),
        ),
        np.eye(4),
        Capsule(0.002345, 0.0143),
        pose([0.01651, 0.63727, -0.01897], [0.04092, -0.468195, 0.245011]),
        0.0244611,
    ),
]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("linked", [False, True])
@pytest.mark.parametrize(("first", "at", "second", "place", "believed_m"), WORST_CLAIMS)
def test_the_worst_claims_stay_mended(
    first: Shape, at: np.ndarray, second: Shape, place: np.ndarray, believed_m: float, linked: bool, backend: str
) -> None:
    true, case = true_distance((first, at), (second, place)), Case(first, second, at, place, linked, "distances")
    assert true.high < 0.95 * believed_m
    checker, pairs = world_of([case], backend, load("planar_2r"))
    for call, values in claims(checker, pairs).items():
        assert values[0] <= true.high + checker.error(values[0]), call
    assert claims(checker, pairs)["distances"][0] == pytest.approx(true.low, abs=1e-5)
    for margin, free in ((true.high + 1e-4, False), (true.low - 1e-4, True)):
        kept, _ = world_of([case], backend, load("planar_2r"), margin)
        q = np.array([[0.7, -0.4]])
        assert (kept.first_contact(q) is None) is free
        assert kept.bound.looks_free(q) is free


@pytest.mark.parametrize(("first", "at", "second", "place", "believed_m"), WORST_CLAIMS)
def test_fcl_still_says_so(first: Shape, at: np.ndarray, second: Shape, place: np.ndarray, believed_m: float) -> None:
    """Should a new version of FCL be right, what is said of it in comments is out of date."""
    things = [
        fcl.CollisionObject(_geometry(shape), fcl.Transform(where[:3, :3], where[:3, 3]))
        for shape, where in ((first, at), (second, place))
    ]
    reported = fcl.distance(*things, fcl.DistanceRequest(), fcl.DistanceResult())
    assert reported == pytest.approx(believed_m, rel=1e-3)
