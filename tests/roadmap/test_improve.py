"""Refined paths and searches: against the exact optimum of a planar arm, cheaper, proven, above floors, repeatable."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from planner.base.request import Charge, Metric, PlanRequest
from planner.collision.edge_prover import EdgeProver
from planner.costs.network import build_network
from planner.kinematics.manipulability import manipulability
from planner.paths.measure import corners, joint_path_length, path_contact, path_manipulability
from planner.plan_record import Plan
from planner.planning import plan
from planner.roadmap.improve import improve, without_last_grown
from planner.roadmap.informed import _in_ellipsoid
from planner.roadmap.motion_cost import MotionCost
from planner.roadmap.refine import PathRefiner, cut
from planner.world.poses import pose
from planner.world.scene import Obstacle, Scene
from planner.world.shapes import Box
from tests.worlds import checker_of, load, small_plan

BAR = Scene("bar", (Obstacle("box", Box((0.1, 0.04, 0.2)), pose([0.75, 0, 0])),))
ASKED = PlanRequest(robot="planar_2r", scene=BAR, start="q:-1.0,0.8", goal="q:1.3,-0.8", nodes=60, beta=1.0)
SHORTEST = 3.646  # rad: the convex hull of ends and contact states, bisected at 400 columns; the other side takes 3.663


@lru_cache
def unrefined() -> Plan:
    return plan(replace(small_plan().request, effort=0))


@pytest.mark.parametrize("beta", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("charge", ["nodes", "edges"])
@pytest.mark.parametrize("metric", ["joint", "workspace"])
def test_motions_cost_what_the_network_charges(beta: float, charge: Charge, metric: Metric) -> None:
    made = small_plan()
    roadmap = made.roadmap
    network = build_network(roadmap, beta, metric=metric, charge=charge)
    cost = MotionCost(made.robot, roadmap.scale, beta, metric=metric, charge=charge, longest=np.inf)
    a, b = roadmap.nodes[network.tails], roadmap.nodes[network.indices]
    theirs = network.arcs(np.zeros(network.n_arcs))
    # the tool's path is summed over fewer points here
    np.testing.assert_allclose(cost(a, b), theirs, rtol=1e-9 if metric == "joint" else 0.04)


@pytest.mark.parametrize("beta", [0.0, 0.5, 1.0])
def test_rounds_make_a_path_cheaper_and_keep_its_motions_proven(beta: float) -> None:
    made = unrefined()
    refiner = PathRefiner(EdgeProver(made.checker), MotionCost(made.robot, made.roadmap.scale, beta))
    path = cut(made.path, 1.0)
    refined = refiner.finish(refiner.round(refiner.round(path)))
    np.testing.assert_array_equal(refined[[0, -1]], path[[0, -1]])
    assert refiner.total(refined) < refiner.total(path)
    assert EdgeProver(made.checker).prove(refined[:-1], np.diff(refined, axis=0)).free.all()
    assert path_contact(made.checker, refined) is None
    assert ((refined >= made.robot.lower) & (refined <= made.robot.upper)).all()


def test_in_open_space_a_detour_becomes_the_straight_motion() -> None:
    checker = checker_of("planar_2r")
    refiner = PathRefiner(EdgeProver(checker), MotionCost(load("planar_2r"), small_plan().roadmap.scale, 1.0))
    bent = np.array([[0.0, 0.5], [0.6, 1.8], [-0.3, 0.9], [1.0, 1.0]])
    np.testing.assert_array_equal(refiner.round(bent), bent[[0, -1]])


def test_a_floor_holds() -> None:
    made = unrefined()
    inner = made.path[1:-1]
    floor = 0.8 * path_manipulability(made.robot, inner).min()
    cost = MotionCost(made.robot, made.roadmap.scale, 1.0, floor)
    refined = PathRefiner(EdgeProver(made.checker), cost).round(inner)
    assert path_manipulability(made.robot, refined).min() >= floor


def test_the_effort_converges_to_the_shortest_path() -> None:
    found = [plan(replace(ASKED, effort=effort)) for effort in (0, 30)]
    length = [joint_path_length(each.path) for each in found]
    assert SHORTEST - 1e-3 < length[1] < 1.005 * SHORTEST
    assert length[1] < length[0]
    assert corners(found[1].path) <= 6
    costs = [cost for _, cost in found[1].curve]
    assert costs == sorted(costs, reverse=True)


def test_improvement_keeps_the_roadmap_and_repeats() -> None:
    made = small_plan()
    cost = MotionCost(made.robot, made.roadmap.scale, 0.5, charge="edges")
    one, two = (improve(made.roadmap, made.checker, cost, made.path, 2, seed=4) for _ in range(2))
    assert one.roadmap.sha256 == two.roadmap.sha256
    assert one.curve == two.curve
    n = len(made.roadmap.nodes)
    np.testing.assert_array_equal(one.roadmap.nodes[:n], made.roadmap.nodes)
    theirs, mine = ({tuple(edge) for edge in each.edges.tolist()} for each in (one.roadmap, made.roadmap))
    assert mine <= theirs


def test_the_last_grown_nodes_make_room() -> None:
    made = small_plan()
    n, path = len(made.roadmap.nodes), made.path_nodes
    fewer = without_last_grown(made.roadmap, n, n - 20, path)
    assert len(fewer.nodes) == n - 20
    assert fewer.connected
    kept = {q.tobytes() for q in fewer.nodes}
    assert {q.tobytes() for q in made.roadmap.nodes[path]} <= kept
    assert {q.tobytes() for q in made.roadmap.nodes[: n - 20 - len(path)]} <= kept


def test_samples_fill_the_ellipsoid() -> None:
    robot, rng = load("planar_2r"), np.random.default_rng(0)
    a, b = np.array([-0.5, 0.2]), np.array([0.4, -0.3])
    q = _in_ellipsoid(robot, a, b, 1.3, 4000, rng)
    far = np.linalg.norm(q - a, axis=1) + np.linalg.norm(q - b, axis=1)
    assert far.max() <= 1.3 + 1e-12
    inner = np.linalg.norm(q - a, axis=1) + np.linalg.norm(q - b, axis=1) < np.sqrt(1.06 + 0.25 * (1.69 - 1.06))
    area = [length * np.sqrt(length**2 - 1.06) for length in (np.sqrt(1.06 + 0.25 * (1.69 - 1.06)), 1.3)]
    assert inner.mean() == pytest.approx(area[0] / area[1], abs=0.03)


def test_above_ends_keeps_w_above_the_lower_end() -> None:
    found = plan(replace(ASKED, goal="q:1.3,0.8", beta=0.2, above_ends=True))
    w = path_manipulability(found.robot, found.path)
    ends = manipulability(found.robot, found.path[[0, -1]])
    assert w.min() >= (1.0 - 1e-6) * ends.min()
