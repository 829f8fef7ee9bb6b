"""Strands: cheaper than where they came from, proven, within limits; the way out of a singularity."""

from __future__ import annotations

import numpy as np
import pytest

from planner.base.request import PlanRequest
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.manipulability import manipulability
from planner.paths.measure import joint_path_length, path_contact, path_manipulability
from planner.planning import plan
from planner.roadmap.best_paths import MotionCost, _with_dips, add_refined_paths, best_path, refine_path
from planner.roadmap.build import DENSITY, build_roadmap
from planner.roadmap.roadmap import component_labels
from planner.roadmap.scale import manipulability_cost
from tests.worlds import checker_of, load, make_post, small_plan


def total(cost: MotionCost, path: np.ndarray) -> float:
    return float(cost(path[:-1], path[1:]).sum())


@pytest.mark.parametrize("beta", [0.0, 0.25, 1.0])
def test_a_pulled_path_is_cheaper_and_proven(beta: float) -> None:
    made = small_plan()
    checker, path = made.checker, made.path
    cost = MotionCost(made.robot, made.roadmap.scale, beta)
    *_, pulled = refine_path(EdgeProver(checker), path, cost)
    np.testing.assert_allclose(pulled[[0, -1]], path[[0, -1]], rtol=0, atol=1e-12)
    assert total(cost, pulled) <= total(cost, path)
    assert path_contact(checker, pulled) is None
    assert EdgeProver(checker).prove(pulled[:-1], np.diff(pulled, axis=0)).free.all()
    assert ((pulled >= made.robot.lower) & (pulled <= made.robot.upper)).all()


def test_pulling_in_open_space_straightens_a_detour() -> None:
    checker = checker_of("planar_2r")
    bent = np.array([[0.0, 0.5], [0.6, 1.8], [-0.3, 0.9], [1.0, 1.0]])
    *_, straight = refine_path(
        EdgeProver(checker), bent, MotionCost(load("planar_2r"), small_plan().roadmap.scale, 1.0)
    )
    assert joint_path_length(straight) == pytest.approx(np.linalg.norm(bent[-1] - bent[0]), rel=0.01)


def test_pulling_downhill_in_omega_raises_mean_w() -> None:
    made = small_plan()
    prover, scale = EdgeProver(made.checker), made.roadmap.scale
    *_, short = refine_path(prover, made.path, MotionCost(made.robot, scale, 1.0))
    *_, good = refine_path(prover, made.path, MotionCost(made.robot, scale, 0.0))
    assert path_manipulability(made.robot, good).mean() > 1.1 * path_manipulability(made.robot, short).mean()


def test_a_floor_is_never_crossed() -> None:
    made = small_plan()
    w = manipulability(made.robot, made.path)
    inner = made.path[1:-1]
    floor = 0.8 * min(path_manipulability(made.robot, inner).min(), w.max())
    *_, pulled = refine_path(EdgeProver(made.checker), inner, MotionCost(made.robot, made.roadmap.scale, 1.0, floor))
    assert path_manipulability(made.robot, pulled).min() >= 0.98 * floor


def test_motion_cost_is_the_integral() -> None:
    made, rng = small_plan(), np.random.default_rng(0)
    a = rng.uniform(made.robot.lower, made.robot.upper, (5, 7))
    b = a + rng.uniform(-0.2, 0.2, a.shape)
    ours = MotionCost(made.robot, made.roadmap.scale, 0.3)(a, b)
    for p, q, value in zip(a, b, ours, strict=True):
        fine = p + np.linspace(0, 1, 401)[:, None] * (q - p)
        omega = manipulability_cost(manipulability(made.robot, fine), made.roadmap.scale)
        length = np.linalg.norm(q - p)
        assert value == pytest.approx(length * (0.7 * np.trapezoid(omega, dx=1 / 400) + 0.3), rel=0.03)


def test_refined_paths_join_the_roadmap_and_leave_the_rest() -> None:
    checker = make_post()
    bare = build_roadmap(checker.robot, checker, *ends(), 100, 0, refined=0.0)
    nodes, edges = add_refined_paths(EdgeProver(checker), bare.nodes, bare.edges, bare.starts, bare.goals, 40)
    np.testing.assert_array_equal(nodes[:100], bare.nodes)
    np.testing.assert_array_equal(edges[: len(bare.edges)], bare.edges)
    assert 100 < len(nodes) <= 140
    assert component_labels(len(nodes), edges).max() == component_labels(100, bare.edges).max()
    none, same = add_refined_paths(EdgeProver(checker), bare.nodes, bare.edges, bare.starts, bare.goals, 0)
    assert (len(none), len(same)) == (100, len(bare.edges))


def test_a_roadmap_with_refined_paths_has_its_size_and_repeats() -> None:
    made = [build_roadmap(make_post().robot, make_post(), *ends(), 100, 3) for _ in range(2)]
    assert made[0].sha256 == made[1].sha256
    assert len(made[0].nodes) == 100
    assert len(made[0].edges) == round(100 * DENSITY)


def test_refined_paths_make_better_paths() -> None:
    """The integrated cost on a roadmap with refined paths: at neither end of beta worse, at 0 better."""
    ratios = []
    for beta in (0.0, 1.0):
        request = PlanRequest(nodes=150, beta=beta, charge="edges")
        found = plan(request)
        without = build_roadmap(
            found.robot,
            found.checker,
            found.roadmap.nodes[found.roadmap.starts],
            found.roadmap.nodes[found.roadmap.goals],
            150,
            0,
            refined=0.0,
        )
        nodes, edges = without.nodes, without.edges
        cost = MotionCost(found.robot, found.roadmap.scale, beta)
        best = best_path(nodes, edges, cost(nodes[edges[:, 0]], nodes[edges[:, 1]]), without.starts, without.goals)
        assert best is not None
        ratios.append(total(cost, found.path) / total(cost, best))
    assert max(ratios) <= 1.0
    assert min(ratios) < 0.8


def ends() -> tuple[np.ndarray, np.ndarray]:
    from tests.worlds import POST_GOAL, POST_START

    return POST_START[None], POST_GOAL[None]


# out of a singularity


def test_a_dip_inside_a_motion_becomes_a_node() -> None:
    robot = load("planar_2r")  # w = l1 l2 |sin q2|
    path = np.array([[0.0, 0.8], [0.2, -0.4], [0.4, -0.9]])
    dipped = _with_dips(robot, path)
    assert len(dipped) == 4
    np.testing.assert_array_equal(dipped[[0, 2, 3]], path)
    assert manipulability(robot, dipped)[1] < 0.1 * manipulability(robot, path).min()
    (x, y), (u, v) = dipped[1] - path[0], path[1] - path[0]
    assert x * v - y * u == pytest.approx(0.0, abs=1e-12)
