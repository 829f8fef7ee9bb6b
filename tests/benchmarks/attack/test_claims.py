"""Claims about distances: wrong ones are found, and those once found stay mended."""

from __future__ import annotations

import json

import fcl
import numpy as np
import pytest

from benchmarks.attack.cases import Case
from benchmarks.attack.claims import attack_claims, claims, world_of
from benchmarks.attack.true_distance import true_distance
from planner.base.progress import QUIET
from planner.collision import BACKENDS
from planner.collision.bounds import ClearanceBound
from planner.collision.coal import CoalChecker
from planner.collision.fcl import FclChecker, _geometry
from planner.models.poses import pose
from planner.models.shapes import Box, Capsule, Mesh, Shape
from tests.worlds import load


def believed(self: FclChecker, rotation: np.ndarray, position: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """FCL's own distances of meshes, as they were once believed."""
    return np.array([believed_of_one(self, int(pair), rotation, position) for pair in pairs])


def believed_of_one(self: FclChecker, pair: int, rotation: np.ndarray, position: np.ndarray) -> float:
    first, second = (self._placed(k, rotation, position) for k in self.world.items_of(pair))
    gap = fcl.distance(first, second, fcl.DistanceRequest(), fcl.DistanceResult())
    return gap if gap > 1e-12 else -1.0


def test_fcls_own_distances_of_meshes_are_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FclChecker, "distances", believed)
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
