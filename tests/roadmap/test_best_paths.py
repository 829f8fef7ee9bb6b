"""Refined paths as part of a roadmap: its size, what it had before, better paths, dips that become nodes."""

from __future__ import annotations

import numpy as np
import pytest

from planner.collision.edge_prover import EdgeProver
from planner.cost.motion_cost import MotionCost
from planner.kinematics.manipulability import manipulability
from planner.planning.plan import plan
from planner.problem.request import Objective, PlanRequest
from planner.roadmap.best_paths import _with_dips, add_refined_paths, best_path
from planner.roadmap.build import DENSITY, build_roadmap
from planner.roadmap.roadmap import component_labels
from tests.worlds import load, make_post


def total(cost: MotionCost, path: np.ndarray) -> float:
    return float(cost(path[:-1], path[1:]).sum())


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
        request = PlanRequest.from_options(nodes=150, beta=beta, charge="edges")
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
        cost = MotionCost(found.robot, found.roadmap.scale, Objective(beta), longest=np.inf)
        best = best_path(nodes, edges, cost(nodes[edges[:, 0]], nodes[edges[:, 1]]), without.starts, without.goals)
        assert best is not None
        ratios.append(total(cost, found.path) / total(cost, best))
    assert max(ratios) <= 1.0
    assert min(ratios) < 0.8


def ends() -> tuple[np.ndarray, np.ndarray]:
    from tests.worlds import POST_GOAL, POST_START

    return POST_START[None], POST_GOAL[None]


def test_a_dip_inside_a_motion_becomes_a_node() -> None:
    robot = load("planar_2r")  # w = l1 l2 |sin q2|
    path = np.array([[0.0, 0.8], [0.2, -0.4], [0.4, -0.9]])
    dipped = _with_dips(robot, path)
    assert len(dipped) == 4
    np.testing.assert_array_equal(dipped[[0, 2, 3]], path)
    assert manipulability(robot, dipped)[1] < 0.1 * manipulability(robot, path).min()
    (x, y), (u, v) = dipped[1] - path[0], path[1] - path[0]
    assert x * v - y * u == pytest.approx(0.0, abs=1e-12)
