"""The compiled library against independent methods: certified distances, SciPy's Dijkstra, one thread or many."""

from __future__ import annotations

import math
from itertools import combinations_with_replacement

import numpy as np
import pytest

from planner.collision.bounds import ClearanceBound
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.forward import Chain, joint_placements
from planner.kinematics.manipulability import manipulability, manipulability_along
from planner.native import library
from planner.native.library import manipulability_costs
from planner.studies.bench_attack.cases import Case
from planner.studies.bench_attack.claims import world_of
from planner.studies.bench_attack.true_distance import true_distance
from planner.world.poses import pose
from planner.world.shapes import Capsule, Cylinder, Mesh, Shape, Sphere
from tests.random_shapes import KINDS, blob, box_mesh, random_pose, random_shape
from tests.worlds import checker_of, load, random_q

REGIMES = ("normal", "thin", "large")
Q = np.array([[0.7, -0.4]])  # where world_of puts its arm


def close(*shapes: tuple[Shape, np.ndarray], linked: bool = False) -> float:
    """The close bound (m) on the distance of two placed shapes."""
    (a, at_a), (b, at_b) = shapes
    checker, pairs = world_of([Case(a, b, at_a, at_b, linked, "close")], "coal", load("planar_2r"))
    placed = joint_placements(checker.chain, Q)
    return float(checker.bound.close(*placed, np.zeros(1, dtype=np.int64), pairs)[0])


@pytest.mark.parametrize(("first", "second"), list(combinations_with_replacement(KINDS, 2)))
@pytest.mark.parametrize("linked", [False, True])
def test_a_close_bound_holds_and_is_close(first: str, second: str, linked: bool) -> None:
    rng, apart = np.random.default_rng(7), 0
    for _ in range(25):
        a, b = (random_shape(rng, kind, REGIMES[int(rng.integers(3))]) for kind in (first, second))
        placed = (a, random_pose(rng)), (b, random_pose(rng))
        true, gap = true_distance(*placed), close(*placed, linked=linked)
        assert gap <= true.high + 1e-12
        assert true.low - gap <= 2e-6 or Mesh in (type(a), type(b))  # dents of far meshes are not looked into
        apart += true.low > 0.0
    assert apart > 5


@pytest.mark.parametrize("kind", KINDS)
def test_a_bumpy_mesh_beside_anything(kind: str) -> None:
    rng, near = np.random.default_rng(3), 0
    for _ in range(25):
        placed = (random_shape(rng, kind), random_pose(rng, 0.6)), (blob(rng, float(rng.uniform(0.2, 1))), np.eye(4))
        true, gap = true_distance(*placed), close(*placed)
        assert gap <= true.high + 1e-12
        assert gap >= 0.3 * true.low - 2e-6  # a dent is no deeper than that beside it
        near += true.low > 0.0
    assert near > 5


def test_a_ball_in_a_dent_is_told_by_the_triangles() -> None:
    """Between two plates the hulls overlap; inside an open box too: meshes that are not convex are surfaces."""
    plates = Mesh(
        np.array([[x, y, z] for z in (-0.2, 0.2) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float),
        np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]),
    )
    box = box_mesh((1.0, 1.0, 1.0))
    for mesh, gap in ((plates, 0.15), (Mesh(box.vertices, box.triangles[2:]), 0.45)):
        assert close((Sphere(0.05), np.eye(4)), (mesh, np.eye(4))) == pytest.approx(gap, abs=1e-6)


def test_what_touches_has_no_gap() -> None:
    wall = Mesh(np.array([[0.0, -1, -1], [0.0, 1, -1], [0.0, 0, 1]]), np.array([[0, 1, 2]]))
    for shape in (Cylinder(0.05, 0.2), Capsule(0.05, 0.1), box_mesh((0.2, 0.1, 0.1))):
        assert close((shape, pose([0.02, 0, 0])), (wall, np.eye(4))) == 0.0
        assert close((shape, pose([0.02, 0.01, 0], rpy=[0.1, 0.2, 0.3])), (shape, np.eye(4))) == 0.0


def test_triangles_without_area() -> None:
    needle = Mesh(np.array([[0.0, 0, 0], [1.0, 0, 0], [0.5, 0, 0]]), np.array([[0, 1, 2], [0, 0, 0]]))
    assert close((Sphere(0.1), pose([0.3, 0.4, 0])), (needle, np.eye(4))) == pytest.approx(0.3)


def test_the_same_bits_on_one_thread_and_on_many(monkeypatch: pytest.MonkeyPatch) -> None:
    checker, robot = checker_of("panda", "shelf"), load("panda")
    q = random_q(robot, 300, seed=1)
    answers = []
    for count in (1, 2, 7):
        monkeypatch.setattr(library, "threads", lambda count=count: count)
        prover, delta = EdgeProver(checker), 0.3 * np.roll(q, 1, axis=0)
        proofs, pairs = prover.prove(q, delta), np.full(150, 2)
        first = prover.first_free(q, delta, pairs, np.full(50, 3))
        w = manipulability(robot, q)
        answers.append((proofs.verdict, proofs.pair, proofs.samples, proofs.clearance, first, w))
    for other in answers[1:]:
        for one, same in zip(answers[0], other, strict=True):
            np.testing.assert_array_equal(one, same)


def test_costs_of_w_take_the_math_modules_logarithm() -> None:
    w, low, high, zeta = 10.0 ** np.random.default_rng(0).uniform(-9, 1, (4, 500)), 1e-6, 0.5, 0.01
    share = (np.vectorize(math.log)(high) - np.vectorize(math.log)(np.clip(w, low, high))) / (
        math.log(high) - math.log(low)
    )
    assert np.array_equal(manipulability_costs(w, low, high, zeta, 1), zeta + (1.0 - zeta) * share)


@pytest.mark.parametrize("name", ["panda", "ur5", "planar_2r"])
def test_w_of_several_has_the_bits_of_w_of_one(name: str) -> None:
    robot = load(name)
    q, delta, shares = random_q(robot, 7, seed=3), random_q(robot, 7, seed=4), np.array([0.0, 0.3, 1.0])
    whole = manipulability(robot, q)
    assert np.array_equal(whole, [manipulability(robot, one)[0] for one in q])
    along = manipulability_along(robot, q, delta, shares)
    assert np.array_equal(along, np.stack([manipulability(robot, q + share * delta) for share in shares], axis=1))


def test_a_motion_looks_free_where_its_states_do() -> None:
    """The end, the middle and states at even distances; not the start, where a motion is already."""
    checker, robot = checker_of("panda", "shelf"), load("panda")
    reach, verdicts = checker.world.reach.bodies, []
    for a, b in zip(random_q(robot, 120, seed=5), random_q(robot, 120, seed=6), strict=True):
        delta = 0.3 * (b - a)
        for step in (np.inf, 0.05):
            count = 1 if np.isinf(step) else math.ceil(float((reach @ np.abs(delta)).max()) / step)
            shares = np.array([1.0, 0.5, *(np.arange(1, count) / count)])
            looks = checker.bound.motion_looks_free(a, delta, step)
            assert looks == checker.bound.looks_free(a + shares[:, None] * delta)
            verdicts.append(looks)
    assert 20 < sum(verdicts) < 220


def test_points_outlive_the_arrays_they_came_from() -> None:
    """The library keeps copies: a world can be asked after everything that it was made of is gone."""
    world = checker_of("ur5", "table").world
    bound, robot = ClearanceBound(world), world.robot
    placed = joint_placements(Chain.of(robot), random_q(robot, 5, seed=2))
    before = bound.coarse(*placed)
    del world
    np.testing.assert_array_equal(bound.coarse(*placed), before)
