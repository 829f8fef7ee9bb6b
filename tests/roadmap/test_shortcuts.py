"""Short cuts: proven, on the cheapest way, and never dearer than what was there."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from planner import gabf
from planner.collision.edge_prover import EdgeProver, recheck
from planner.costs.network import build_network
from planner.roadmap.best_paths import BETAS
from planner.roadmap.edge_certificates import RecordingProver
from planner.roadmap.enlarge import enlarged
from planner.roadmap.motion_cost import MotionCost
from planner.roadmap.motions import Motions
from planner.roadmap.shortcuts import (
    _best_paths,
    _cheaper,
    _cheapest_steps,
    _Verdicts,
    shortcuts,
    straight_paths,
    subdivided,
)
from tests.worlds import POST_GOAL, POST_START, load, make_post, post_roadmap


@pytest.fixture(scope="module")
def pairs():
    """A roadmap's starts and goals at random nodes, and the same with short cuts."""
    made, rng = [], np.random.default_rng(3)
    for _ in range(8):
        start, goal = rng.choice(len(post_roadmap().nodes), 2, replace=False)
        old = replace(post_roadmap(), starts=np.array([start]), goals=np.array([goal]))
        prover = RecordingProver(make_post())
        found = shortcuts(old, prover, 0.8)
        made.append((old, enlarged(old, prover, found.nodes()[len(old.nodes) :], found.edges())))
    return made


@pytest.mark.parametrize("beta", [0.0, 0.25, 1.0])
def test_paths_become_cheaper_and_none_dearer(pairs, beta):
    def cost(roadmap):
        return float(gabf.oracle(build_network(roadmap, beta, charge="edges"))[roadmap.starts[0]])

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
            assert recheck(make_post(), new.nodes[i], delta, 1e-3) is None


def test_steps_and_skips_against_every_way_there_is():
    rng = np.random.default_rng(0)
    for _ in range(30):
        step = rng.uniform(0.5, 1.5, 5)
        skips = {pair: float(rng.uniform(0.3, 4)) for pair in itertools.combinations(range(6), 2) if rng.random() < 0.5}
        skips = {(i, j): price for (i, j), price in skips.items() if j > i + 1}

        def price(i, j, step=step, skips=skips):
            return min(skips.get((i, j), np.inf), step[i] if j == i + 1 else np.inf)

        ways = [(0, *inner, 5) for k in range(5) for inner in itertools.combinations(range(1, 5), k)]
        best = min(ways, key=lambda way: sum(itertools.starmap(price, itertools.pairwise(way))))
        assert sorted(_cheapest_steps(step, skips)) == [(i, j) for i, j in itertools.pairwise(best) if j > i + 1]


def test_straight_motions_are_those_that_are_proven():
    motions = Motions(RecordingProver(make_post()))
    goals = np.array([POST_GOAL, POST_START, POST_START + np.array([0.1, 1.2])])
    (path,) = straight_paths(motions, POST_START[None], goals, 0.5)
    np.testing.assert_array_equal(path[[0, -1]], [POST_START, goals[2]])
    assert len(path) == 4
    steep = Motions(motions.prover, floor=10.0)
    assert straight_paths(steep, POST_START[None], goals, 0.5) == []


def test_pieces_of_a_path_that_wraps():
    robot = load("kinova")
    first = np.where(robot.continuous, 3.0, robot.home)
    last = np.where(robot.continuous, -3.0, robot.home)
    path = subdivided(robot, np.array([first, last]), 0.1)
    np.testing.assert_array_equal(path[[0, -1]], [first, last])
    steps = np.linalg.norm(robot.difference(path[:-1], path[1:]), axis=1)
    np.testing.assert_allclose(steps.sum(), np.linalg.norm(robot.difference(first, last)))
    assert steps.max() <= 0.1 + 1e-9


def test_the_way_is_the_cheapest_of_all_that_is_proven_though_few_motions_are_asked_for(monkeypatch):
    """Against the cheapest way over every skip that is proven, on best paths of a random roadmap."""
    fewer = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        roadmap, prover = post_roadmap(), RecordingProver(make_post())
        start, goal = rng.choice(len(roadmap.nodes), 2, replace=False)
        cost = MotionCost(prover.robot, roadmap.scale, float(rng.choice(BETAS)), longest=np.inf)
        here = replace(roadmap, starts=np.array([start]), goals=np.array([goal]))
        for nodes in _best_paths(here, cost.of_edges(here)):
            path, asked = roadmap.nodes[nodes], []

            def counted(start, delta, asked=asked, prover=prover):
                asked.append(len(start))
                return EdgeProver.free(prover, start, delta)

            monkeypatch.setattr(prover, "free", counted)
            i, j = np.triu_indices(len(path), 1)
            found = _cheaper(_Verdicts(prover), path, cost(path[i], path[j]))
            step, (i, j) = cost(path[:-1], path[1:]), np.triu_indices(len(path), 2)
            direct, around = cost(path[i], path[j]), np.array([step[a:b].sum() for a, b in zip(i, j, strict=True)])
            worth = np.flatnonzero((direct < around) & EdgeProver.free(prover, path[i], path[j] - path[i]))
            every = {(int(i[row]), int(j[row])): float(direct[row]) for row in worth}
            assert found == _cheapest_steps(step, every)
            fewer += sum(asked) < (direct < around).sum()
    assert fewer > 3
