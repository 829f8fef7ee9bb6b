"""The lazy search over all modes against every combination planned one by one, with all edges proven beforehand."""

import heapq
import itertools
from dataclasses import replace

import numpy as np
import pytest

from planner.base.resolutions import PROOF
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.forward import tool_pose
from planner.robot.poses import pose
from planner.robot.shapes import Obstacle, Sphere
from planner.tasks.modes import BLOCKED, FREE, OPEN, Mode, Modes
from planner.tasks.network import LazySearch, TaskNetwork
from planner.tasks.plan import TaskPlanner
from tests.tasks.cases import MUG, SCENE, SMALL, small


def dijkstra(network: TaskNetwork, cost, usable) -> float:
    """The cheapest way from start to a goal over ``usable`` arcs."""
    arcs_of: dict[int, list[int]] = {}
    for arc in np.flatnonzero(usable).tolist():
        arcs_of.setdefault(int(network.tails[arc]), []).append(arc)
    goals, best, queue = set(network.goals.tolist()), {network.start: 0.0}, [(0.0, network.start)]
    while queue:
        so_far, node = heapq.heappop(queue)
        if node in goals:
            return so_far
        if so_far > best[node]:
            continue
        for arc in arcs_of.get(node, ()):
            other, total = int(network.heads[arc]), so_far + cost[arc]
            if total < best.get(other, np.inf):
                best[other] = total
                heapq.heappush(queue, (total, other))
    return np.inf


def proven_eagerly(planner: TaskPlanner) -> np.ndarray:
    """(arcs,) which arcs are free in their mode, by one prover of everything in it and no memory of other modes."""
    network, modes = planner.network, planner.candidates.modes
    assert network is not None
    free = np.zeros(len(network.tails), dtype=bool)
    for number, mode in enumerate(network.modes):
        arcs = network.of_mode[number]
        prover = EdgeProver(modes.checker_of(mode))
        motions = np.unique(network.motion[arcs])
        start, delta, owner = modes.motions.select(motions)
        bad = owner[~prover.prove(start, delta, PROOF).free]
        free[arcs] = ~np.isin(network.motion[arcs], bad)
    return free


def verdicts(modes: Modes, mode: Mode, motions: np.ndarray) -> np.ndarray:
    """(k,) what is known of ``motions`` (k,) in a mode: one clause that blocks is enough."""
    found = np.array([modes.verdicts_of(clause)[motions] for clause in modes.clauses(mode)])
    blocked, free = (found == BLOCKED).any(axis=0), (found == FREE).all(axis=0)
    return np.where(blocked, BLOCKED, np.where(free, FREE, OPEN))


@pytest.fixture(scope="module")
def brute() -> tuple[TaskPlanner, np.ndarray]:
    planner = small()
    return planner, proven_eagerly(planner)


@pytest.mark.parametrize("beta", [0.0, 0.3, 0.5, 1.0])
def test_costs_as_much_as_the_best_of_all_combinations_one_by_one(brute, beta: float) -> None:
    planner, free = brute
    network = planner.network
    cost = (1 - beta) * network.costs[:, 0] + beta * network.costs[:, 1]
    ways = [(way, way.candidate.grasp, way.candidate.place) for way in network.transitions if way.step < 2]
    picks = {grasp for way, grasp, _ in ways if way.step == 0}
    places = {place for way, _, place in ways if way.step == 1}
    assert (len(picks), len(places)) == (3, 2)
    totals = {}
    for grasp, place in itertools.product(picks, places):
        barred = [way.first for way, g, p in ways if g != grasp or (way.step == 1 and p != place)]
        usable = free & ~np.isin(network.heads, barred)
        totals[grasp, place] = dijkstra(network, cost, usable)
    found = planner.plan(beta=beta, timing=None)
    assert found.cost is not None
    assert found.cost.total == pytest.approx(min(totals.values()), rel=1e-9)
    assert found.cost.total == pytest.approx(found.cost_to_go.x[network.start], rel=1e-9)
    assert np.isfinite(list(totals.values())).sum() > 1  # or there is nothing to choose


def test_what_modes_share_is_refused_and_what_they_do_not_share_too(brute) -> None:
    """The proofs of parts say together what one prover of all says."""
    planner, free = brute
    found, modes = planner.plan(timing=None), planner.candidates.modes
    network = planner.network
    for number, mode in enumerate(network.modes):
        arcs = network.of_mode[number]
        verdict = verdicts(modes, mode, network.motion[arcs])
        assert not (free[arcs] & (verdict == BLOCKED)).any()
        assert not (~free[arcs] & (verdict == FREE)).any()
    assert found.modes.arcs_refused > 0
    held = [m for m in network.modes if m.held is not None]
    assert any(
        (verdicts(modes, m, network.motion[network.of_mode[network.modes.index(m)]]) == BLOCKED).any() for m in held
    )


def test_another_start_is_answered_on_what_is_known(brute) -> None:
    planner, _ = brute
    q = planner.roadmap.nodes[40]
    found = planner.plan(start=q, timing=None)
    network = found.network
    assert found.solved
    np.testing.assert_allclose(found.path[0], q)
    more = replace(planner, search=LazySearch(planner.candidates.modes, network, planner.search.law))
    cost = network.costs.mean(axis=1)
    assert found.cost.total == pytest.approx(dijkstra(network, cost, proven_eagerly(more)), rel=1e-9)


def test_intervals_of_beta_are_those_of_the_best_proven_path(brute) -> None:
    planner, free = brute
    found = planner.intervals()
    assert len(found) > 1
    assert (found[0].beta_min, found[-1].beta_max) == (0.0, 1.0)
    for piece, after in itertools.pairwise(found):
        assert piece.beta_max == after.beta_min
    costs = planner.network.costs
    for beta in np.linspace(0.0, 1.0, 21):
        piece = next(p for p in found if p.beta_min <= beta <= p.beta_max)
        best = dijkstra(planner.network, (1 - beta) * costs[:, 0] + beta * costs[:, 1], free)
        assert piece.support.at(beta) == pytest.approx(best, rel=1e-9)


def test_what_only_the_object_in_hand_touches_is_gone_round_at_the_least_cost() -> None:
    """A bead where the mug's foot would pass on the best way: refused once it is proven, and still as brute force."""
    before, robot = small().plan(timing=None), small().candidates.modes.robot
    attach, way = before.segments[1].path[-1], before.segments[3].path
    hold = np.linalg.inv(tool_pose(robot, attach).homogeneous) @ MUG.placement
    mug = tool_pose(robot, 0.5 * (way[0] + way[1])).homogeneous @ hold
    bead = Obstacle("bead", Sphere(0.01), pose(tuple(mug[:3, 3] - 0.1 * mug[:3, 2])))
    scene = replace(SCENE, obstacles=(*SCENE.obstacles, bead))
    planner = TaskPlanner.from_task(replace(SMALL, scene=scene), nodes=100, ik_solutions=2)
    found, network = planner.plan(timing=None), planner.network
    assert found.modes is not None
    assert found.modes.rounds > 1
    assert found.modes.arcs_refused > 0
    assert network is not None
    assert found.cost is not None
    best = dijkstra(network, network.costs.mean(axis=1), proven_eagerly(planner))
    assert found.cost.total == pytest.approx(best, rel=1e-9)
