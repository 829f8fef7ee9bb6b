"""Shortcuts: proven, on the cheapest way, and never dearer than what was there."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from planner import gabf
from planner.collision.edge_prover import EdgeProver
from planner.collision.recheck import sample_segment
from planner.cost.motion_cost import MotionCost
from planner.problem.request import Objective
from planner.roadmap.build import build_roadmap
from planner.roadmap.edges import MotionChecker, RecordingProver, enlarge_roadmap
from planner.roadmap.roadmap import component_labels
from planner.roadmap.shortcuts import (
    BETAS,
    DraftRoadmap,
    _best_paths,
    _find_shortcuts,
    add_refined_paths,
    prove_shortcuts,
    prove_straight_paths,
    subdivide,
)
from planner.search.network import build_network
from tests.worlds import POST_GOAL, POST_START, load, make_post, post_roadmap


def linked(roadmap):
    """The roadmap, and nothing more."""
    nothing = np.zeros((0, 2), dtype=np.int64)
    return DraftRoadmap(roadmap, roadmap.nodes[:0], nothing, roadmap.starts, roadmap.goals)


@pytest.fixture(scope="module")
def pairs():
    """A roadmap's starts and goals at random nodes, and the same with shortcuts."""
    made, rng = [], np.random.default_rng(3)
    for _ in range(8):
        start, goal = rng.choice(len(post_roadmap().nodes), 2, replace=False)
        old = replace(post_roadmap(), starts=np.array([start]), goals=np.array([goal]))
        prover = RecordingProver(make_post())
        found = prove_shortcuts(linked(old), prover, 0.8)
        made.append((old, enlarge_roadmap(old, prover, found.nodes()[len(old.nodes) :], found.edges())))
    return made


@pytest.mark.parametrize("beta", [0.0, 0.25, 1.0])
def test_paths_become_cheaper_and_none_dearer(pairs, beta):
    def cost(roadmap):
        return float(gabf.oracle(build_network(roadmap, beta))[roadmap.starts[0]])

    before, after = (np.array([cost(pair[k]) for pair in pairs]) for k in (0, 1))
    assert (after <= before * (1 + 1e-3)).all()  # an edge is integrated anew in its pieces
    assert (after < 0.99 * before).any()


def test_short_cuts_are_free_and_in_pieces(pairs):
    for old, new in pairs:
        n = len(old.nodes)
        np.testing.assert_array_equal(new.nodes[:n], old.nodes)
        for i, j in {tuple(edge) for edge in new.edges.tolist()} - {tuple(edge) for edge in old.edges.tolist()}:
            delta = new.nodes[j] - new.nodes[i]
            assert np.linalg.norm(delta) <= 0.8 + 1e-9
            assert sample_segment(make_post(), new.nodes[i], delta, 1e-3) is None


def test_straight_motions_are_those_that_are_proven():
    motions = MotionChecker(RecordingProver(make_post()))
    goals = np.array([POST_GOAL, POST_START, POST_START + np.array([0.1, 1.2])])
    (path,) = prove_straight_paths(motions, POST_START[None], goals, 0.5)
    np.testing.assert_array_equal(path[[0, -1]], [POST_START, goals[2]])
    assert len(path) == 4
    steep = MotionChecker(motions.prover, floor=10.0)
    assert prove_straight_paths(steep, POST_START[None], goals, 0.5) == []


@pytest.mark.parametrize("beta", BETAS)
def test_the_way_is_the_cheapest_of_all_that_is_proven(beta):
    """Against Dijkstra over every motion past waypoints that is proven, on best paths of a random roadmap."""
    shorter = 0
    for seed in range(6):
        rng = np.random.default_rng(seed)
        roadmap, prover = post_roadmap(), RecordingProver(make_post())
        start, goal = rng.choice(len(roadmap.nodes), 2, replace=False)
        cost = MotionCost(prover.robot, roadmap.scale, Objective(beta), longest=np.inf)
        here = replace(roadmap, starts=np.array([start]), goals=np.array([goal]))
        (nodes,) = _best_paths(linked(here), linked(here).costs(cost))
        path = roadmap.nodes[nodes]
        i, j = np.triu_indices(len(path), 1)
        price = cost(path[i], path[j])
        found = _find_shortcuts(prover, path, price)
        usable = (j == i + 1) | prover.free(path[i], path[j] - path[i])
        graph = csr_matrix((price[usable], (i[usable], j[usable])), shape=(len(path), len(path)))
        of = dict(zip(zip(i.tolist(), j.tolist(), strict=True), price.tolist(), strict=True))
        passed = {place for a, b in found for place in range(a + 1, b)}
        kept = [place for place in range(len(path)) if place not in passed]
        total = sum(of[pair] for pair in itertools.pairwise(kept))
        assert total == pytest.approx(dijkstra(graph, indices=0)[-1], rel=1e-3)  # smaller gains are not worth a proof
        assert all(usable[(i == a) & (j == b)] for a, b in found)
        shorter += bool(found)
    assert shorter > 1


def test_half_a_turn_is_cut_however_long_pieces_may_be():
    robot = load("kinova")
    ends = np.array([robot.home, robot.normalise(robot.home + np.pi * np.eye(6)[0])])
    rows, parts = subdivide(robot, ends, 10.0)
    assert (len(rows), parts.tolist()) == (3, [2])
    assert robot.is_below_half_turn(robot.difference(rows[:-1], rows[1:])).all()
    np.testing.assert_array_equal(rows[[0, 2]], ends)


def total(cost: MotionCost, path: np.ndarray) -> float:
    return float(cost(path[:-1], path[1:]).sum())


def test_refined_paths_join_the_roadmap_and_leave_the_rest() -> None:
    checker = make_post()
    bare = build_roadmap(checker.robot, checker, POST_START[None], POST_GOAL[None], 100, 0, refined=0.0)
    nodes, edges = add_refined_paths(EdgeProver(checker), bare.nodes, bare.edges, bare.starts, bare.goals, 40)
    np.testing.assert_array_equal(nodes[:100], bare.nodes)
    np.testing.assert_array_equal(edges[: len(bare.edges)], bare.edges)
    assert 100 < len(nodes) <= 140
    assert component_labels(len(nodes), edges).max() == component_labels(100, bare.edges).max()
    none, same = add_refined_paths(EdgeProver(checker), bare.nodes, bare.edges, bare.starts, bare.goals, 0)
    assert (len(none), len(same)) == (100, len(bare.edges))
