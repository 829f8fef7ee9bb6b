"""The compiled library against independent methods: certified distances, SciPy's Dijkstra, one thread or many."""

import math
from itertools import combinations_with_replacement, product

import numpy as np
import pytest

from benchmarks.attack.cases import Case
from benchmarks.attack.claims import world_of
from benchmarks.attack.true_distance import true_distance
from planner.kinematics.forward import joint_placements
from planner.kinematics.manipulability import manipulability, manipulability_along
from planner.native.compiled import NativeChain, NativeWorld
from planner.robot.shapes import Mesh, Shape, Sphere
from tests.random_shapes import KINDS, box_mesh, random_pose, random_shape
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
    for _ in range(6):
        a, b = (random_shape(rng, kind, REGIMES[int(rng.integers(3))]) for kind in (first, second))
        placed = (a, random_pose(rng)), (b, random_pose(rng))
        true, gap = true_distance(*placed), close(*placed, linked=linked)
        assert gap <= true.high + 1e-12
        assert true.low - gap <= 2e-6 or Mesh in (type(a), type(b))  # dents of far meshes are not looked into
        apart += true.low > 0.0
    assert apart > 0


def test_the_triangles_decide_about_a_ball_in_a_dent() -> None:
    """Between two plates the hulls overlap; inside an open box too: meshes that are not convex are surfaces."""
    plates = Mesh(
        np.array([[x, y, z] for z in (-0.2, 0.2) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float),
        np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]),
    )
    box = box_mesh((1.0, 1.0, 1.0))
    for mesh, gap in ((plates, 0.15), (Mesh(box.vertices, box.triangles[2:]), 0.45)):
        assert close((Sphere(0.05), np.eye(4)), (mesh, np.eye(4))) == pytest.approx(gap, abs=1e-6)


@pytest.mark.parametrize("name", ["panda", "ur5", "planar_2r"])
def test_w_of_several_has_the_bits_of_w_of_one(name: str) -> None:
    robot = load(name)
    q, delta, shares = random_q(robot, 7, seed=3), random_q(robot, 7, seed=4), np.array([0.0, 0.3, 1.0])
    whole = manipulability(robot, q)
    assert np.array_equal(whole, [manipulability(robot, one)[0] for one in q])
    along = manipulability_along(robot, q, delta, shares)
    assert np.array_equal(along, np.stack([manipulability(robot, q + share * delta) for share in shares], axis=1))


def chain_of_sines(dof: int) -> NativeChain:
    """Every joint, carried by the base, turns into a frame that holds its sine and 1 - its cosine."""
    rotations = np.zeros((dof, 3, 3, 3))
    rotations[:, 1, 1, 0] = rotations[:, 2, 0, 0] = 1.0
    nothing = np.zeros((dof, 3))
    return NativeChain(np.zeros(dof, np.int64), np.zeros(dof, bool), rotations, nothing, nothing, nothing)


def test_sines_are_those_of_the_math_module() -> None:
    rng, turn = np.random.default_rng(0), np.pi / 2
    angles = np.concatenate(
        [
            rng.uniform(-4, 4, 4000),
            rng.uniform(-1e6, 1e6, 2000),
            turn * rng.integers(-40, 40, 400) + rng.normal(size=400) * 10.0 ** rng.uniform(-18, -1, 400),
            turn * rng.integers(-600_000, 600_000, 400) + rng.normal(size=400) * 10.0 ** rng.uniform(-12, -1, 400),
            rng.uniform(1e6, 1e12, 196),
            [0.0, -0.0, 5e-324, 1e-200, 1e6, -1e6, np.nextafter(1e6, 2e6), 1e300, turn, -turn, 2 * turn],
        ]
    )
    found, _ = chain_of_sines(11).placements(angles.reshape(-1, 11))
    sines, versines = found[1:, :, 1, 0].T.ravel(), found[1:, :, 0, 0].T.ravel()
    assert np.abs(sines - [math.sin(angle) for angle in angles]).max() < 2e-16
    exact = np.array([2.0 * math.sin(0.5 * angle) ** 2 for angle in angles])
    assert np.abs(versines - exact).max() < 5e-16
    small = np.abs(angles) < 0.7
    assert small.sum() > 500
    assert (np.abs(versines - exact)[small] <= 6e-16 * exact[small]).all()
    assert (np.abs(sines - np.sin(angles))[small] <= 4e-16 * np.abs(np.sin(angles))[small]).all()


def test_a_motion_looks_free_where_its_states_do() -> None:
    """The end, the middle and states at even distances; not the start, where a motion is already.

    Whatever it was asked before: the pair that refused a motion is asked first about the next.
    """
    checker, robot = checker_of("panda", "shelf"), load("panda")
    reach, verdicts = checker.world.reach.bodies, []
    kept = {step: checker.bound.make_state_check(step) for step in (np.inf, 0.05)}
    for a, b in zip(random_q(robot, 120, seed=5), random_q(robot, 120, seed=6), strict=True):
        delta = 0.3 * (b - a)
        for step, look in kept.items():
            count = 1 if np.isinf(step) else math.ceil(float((reach @ np.abs(delta)).max()) / step)
            shares = np.array([1.0, 0.5, *(np.arange(1, count) / count)])
            looks = checker.bound.make_state_check(step)(a, delta)
            assert looks == look(a, delta) == checker.bound.is_clear(a + shares[:, None] * delta)
            verdicts.append(looks)
    assert 20 < sum(verdicts) < 220


def test_a_fixed_body_does_not_clear_a_motion() -> None:
    """A ball slides past a post; a second body stands, as a large ball shows near one thing and far from another."""
    straight, x = np.eye(3), np.array([[1.0, 0, 0]])
    chain = NativeChain(
        np.zeros(1, dtype=int),
        np.ones(1, dtype=bool),
        np.stack([straight, 0 * straight, 0 * straight])[None],
        np.zeros((1, 3)),
        x,
        x,
    )
    world = NativeWorld(chain, 0.0)
    for joint, at, size in ((1, [0.0, 0.0, 0.0], 0.01), (0, [0.0, 5.0, 0.0], 0.2)):
        world.add_spheres(world.add_hull(joint, np.array([at]), 0.01), np.array([at]), np.array([size]))
    for at in ([0.3, 0.0, 0.0], [0.0, 5.1, 0.0], [50.0, 50.0, 50.0]):
        corners = np.array(at) + 0.01 * np.array(list(product((-1.0, 1.0), repeat=3)))
        world.add_target(world.add_hull(-1, corners, 0.0), straight, np.array(at), np.full(3, 0.01), 0.0, False)
    pairs = np.array([[body, obstacle] for body in (0, 1) for obstacle in (2, 3, 4)])
    world.set_pairs(pairs, np.ones(len(pairs), dtype=bool))
    reach = np.array([[1.0]] * 3 + [[0.0]] * 3)
    look = world.look(world.bounds(reach, np.array([[1.0], [0.0]]), np.zeros(len(pairs), dtype=bool)), 0.01)
    assert look(np.zeros(1), np.array([0.25]))
    assert not look(np.zeros(1), np.array([1.0])), "the post stands between its start and its middle"
