"""Proofs of motions against coal, which shares no code with them: shapes x curves x margins x both checkers."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.base.polynomials import evaluate
from planner.collision import BACKENDS, make_checker
from planner.collision.checker import is_free
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Capsule, Mesh
from tests.coal_judge import CoalWorld
from tests.random_shapes import KINDS, QUICK, random_curves, random_pose, random_shape
from tests.worlds import body, load, scene_of

COAL = 1e-6  # m: coal's own tolerance
NEAR = 5e-3  # m: a contact may last shorter than samples of a curve are apart
NEEDLE = replace(
    load("planar_2r"), bodies=(replace(body(Capsule(1e-3, 0.35), pose([0.2, 0, 0], [0, np.pi / 2, 0])), joint=2),)
)
ARMS: dict[str, Robot] = {"planar_2r": load("planar_2r"), "needle": NEEDLE, "iiwa14": load("iiwa14")}
REACH = {"planar_2r": 0.8, "needle": 0.6, "iiwa14": 0.9}


def random_scene(arm: str, rng: np.random.Generator) -> Scene:
    """Five obstacles of any kind, half of them millimetres thin, within reach."""
    shapes = [random_shape(rng, KINDS[k], str(rng.choice(["normal", "thin"]))) for k in range(5)]
    return scene_of(*((shape, random_pose(rng, REACH[arm])) for shape in shapes))


def nearest_along(judge: CoalWorld, curve: np.ndarray, pairs: np.ndarray) -> float:
    """The smallest distance (m) of the pairs that coal finds on the curve: at 65 values of s, then around the least."""
    s, spread, least = np.linspace(0.0, 1.0, 65), 1 / 64, np.inf
    for _ in range(4):
        q = evaluate(np.repeat(curve[None], len(s), axis=0), s)
        gaps = np.array([judge.distances(row, pairs).min() for row in q])
        least = min(least, float(gaps.min()))
        s = np.clip(s[gaps.argmin()] + spread * np.linspace(-1.0, 1.0, 13), 0.0, 1.0)
        spread /= 6
    return least


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("arm", ARMS)
def test_proven_free_implies_that_coal_finds_no_contact_at_any_s(arm: str, backend: str) -> None:
    """The claimed clearance is a lower bound, and the pair that is blamed for a contact does come near."""
    verdicts: Counter[int] = Counter()

    @settings(QUICK, max_examples=12 if arm == "iiwa14" else 30)
    @given(st.integers(0, 2**31), st.integers(1, 5), st.sampled_from([0.0, 0.0, 0.02]))
    def check(seed: int, degree: int, margin: float) -> None:
        rng = np.random.default_rng(seed)
        checker = make_checker(ARMS[arm], random_scene(arm, rng), backend, margin)
        curves = random_curves(ARMS[arm], 12, degree, rng, reach=float(rng.choice([0.1, 0.5])))
        prover, judge = EdgeProver(checker), CoalWorld(checker.world)
        proofs = prover.prove_curves(curves)
        moving = np.flatnonzero(checker.world.moving)  # others are as near as they are: they are checked once
        if prover.static_contact is not None:
            assert (proofs.verdict == Verdict.COLLIDES).all()
            return
        verdicts.update(proofs.verdict.tolist())
        free = np.flatnonzero(proofs.free)
        for k in free[np.argsort(proofs.clearance[free])][:2]:
            nearest = nearest_along(judge, curves[k], moving) - margin
            assert nearest > -COAL
            assert proofs.clearance[k] <= nearest + COAL
        for k in np.flatnonzero(proofs.verdict == Verdict.COLLIDES)[:2]:
            pair = int(proofs.pair[k])
            second = checker.world.members(pair)[1]
            other = (checker.world.obstacles if checker.world.is_scene_pair(pair) else checker.world.bodies)[second]
            if not isinstance(other.shape, Mesh):  # a shape may lie wholly inside a mesh, away from its triangles
                assert nearest_along(judge, curves[k], np.array([pair])) <= margin + NEAR

    check()
    assert min(verdicts[Verdict.FREE], verdicts[Verdict.COLLIDES]) > 15
    assert verdicts[Verdict.UNDECIDED] < 0.15 * verdicts.total()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("arm", ARMS)
def test_one_curve_is_proven_as_in_a_batch_and_one_without_length_as_its_state(arm: str, backend: str) -> None:
    @settings(QUICK, max_examples=10)
    @given(st.integers(0, 2**31), st.integers(0, 3))
    def check(seed: int, degree: int) -> None:
        rng = np.random.default_rng(seed)
        checker = make_checker(ARMS[arm], random_scene(arm, rng), backend)
        prover, curves = EdgeProver(checker), random_curves(ARMS[arm], 12, degree, rng, reach=0.2)
        free = prover.prove_curves(curves).free
        assert [prover.all_free(curve[None]) for curve in curves] == free.tolist()
        assert prover.all_free(curves) == free.all()
        assert not free.any() or prover.all_free(curves[free])
        still = curves[:, :1]
        assert prover.prove(still[:, 0], 0.0 * still[:, 0]).free.tolist() == [is_free(checker, q) for q in still[:, 0]]

    check()
