"""The manipulability floor: the search against brute force over all ways, the promise at ten times finer sampling."""

import itertools
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner import gabf
from planner.base.resolutions import W_STATES_PER_EDGE
from planner.cost.scale import COSTS, mean_manipulability_cost
from planner.kinematics.manipulability import manipulability
from planner.planning.plan import plan
from planner.problem.outcome import Outcome
from planner.problem.request import Objective, PlanRequest
from planner.roadmap.roadmap import Roadmap
from planner.search.manipulability_floor import build_layers, find_violation, highest_floor
from planner.search.network import build_network, edge_rows
from planner.trajectory.measure import dense_path
from tests.random_shapes import QUICK
from tests.worlds import load, post_roadmap, small_plan


def invented(seed: int, n: int = 9, floor: float = 0.5) -> Roadmap:
    """A small roadmap whose w, at nodes and along edges, is made up: straight lines between nodes, some with a dip."""
    rng = np.random.default_rng(seed)
    pairs = np.array([(i, j) for i, j in itertools.combinations(range(n), 2) if rng.random() < 0.5])
    w = rng.uniform(0.2, 0.9, n)
    share = np.linspace(0, 1, W_STATES_PER_EDGE)
    along = (1 - share) * w[pairs[:, :1]] + share * w[pairs[:, 1:]]
    dips = rng.random(len(pairs)) < 0.3
    along[dips, 1:-1] -= rng.uniform(0.0, 0.4, (dips.sum(), 1))
    base = small_plan().roadmap
    m = len(pairs)
    return replace(
        base,
        nodes=rng.uniform(-1, 1, (n, base.nodes.shape[1])),
        edges=pairs,
        proven=np.ones(m, dtype=bool),
        starts=[0],
        goals=[n - 1, n - 2],
        manipulability=w,
        joint_length=rng.uniform(0.2, 1.0, m),
        tool_length=np.ones(m),
        edge_manipulability=along,
        edge_cost=np.stack([mean_manipulability_cost(along, base.scale, name) for name in COSTS], axis=1),
        clearance=np.ones(m),
        samples=np.ones(m),
    )


def constraints(roadmap: Roadmap, way: tuple[int, ...], floor: float) -> bool:
    """The promise read word by word, on all states of a way: up to the floor, above it, down to the goal."""
    w = [roadmap.manipulability[way[0]]]
    for i, j in itertools.pairwise(way):
        row = roadmap.edge_manipulability[roadmap.edge_index(i, j)]
        w += list(row if i < j else row[::-1])[1:]
    start, goal = w[0], w[-1]
    above = [k for k, value in enumerate(w) if value >= floor]
    if not above:
        return min(w) >= start - 1e-12 or min(w) >= goal - 1e-12
    first, last = above[0], above[-1]
    return (
        min(w[: first + 1]) >= min(start, floor) - 1e-12
        and min(w[first : last + 1]) >= floor
        and min(w[last:]) >= min(goal, floor) - 1e-12
    )


def ways(roadmap: Roadmap) -> list[tuple[int, ...]]:
    """Walks from the start to a goal that visit no node twice."""
    near: dict[int, set[int]] = {}
    for i, j in roadmap.edges.tolist():
        near.setdefault(i, set()).add(j)
        near.setdefault(j, set()).add(i)
    found, stack = [], [(int(roadmap.starts[0]),)]
    while stack:
        way = stack.pop()
        if way[-1] in roadmap.goals:
            found.append(way)
        stack += [(*way, k) for k in near.get(way[-1], ()) if k not in way]
    return found


@pytest.mark.parametrize("seed", range(25))
def test_the_best_path_above_a_floor_is_that_of_brute_force(seed: int) -> None:
    roadmap, floor = invented(seed), 0.5
    network = build_network(roadmap, Objective(cost_integration="nodes"))
    layered = build_layers(roadmap, network, floor)
    omega, weight = network.node_cost, network.weight

    def cost(way: tuple[int, ...]) -> float:
        arcs = [network.arcs_between(i, j)[0] for i, j in itertools.pairwise(way)]
        return sum(0.5 * omega[network.indices[a]] + 0.5 * weight[a] for a in arcs)

    best = min((cost(way) for way in ways(roadmap) if constraints(roadmap, way, floor)), default=np.inf)
    x = gabf.solve(layered.network, law=gabf.SingularityFree(T=4.0)).x
    assert min(x[layered.starts]) == pytest.approx(best, rel=1e-9)


@pytest.mark.parametrize("charge", ["nodes", "edges"])
def test_a_plan_keeps_its_promise_at_ten_times_finer_sampling(charge: str) -> None:
    floor = 0.05  # start and goal of the paper's scenario lie below
    found = plan(
        request=PlanRequest.from_options(nodes=150, min_manipulability=floor, cost_integration=charge), timing=None
    )
    assert found.outcome is Outcome.SOLVED
    w = manipulability(found.robot, dense_path(found.path, 1e-3))
    assert w[0] < floor
    assert w[-1] < floor
    assert w.min() >= min(floor, w[0], w[-1]) * (1 - 1e-6)
    above = np.flatnonzero(w >= floor)
    assert w[above[0] : above[-1] + 1].min() >= floor
    assert above[-1] - above[0] > 0.5 * len(w)
    assert found.max_error_vs_oracle == 0.0
    plain = small_plan()
    v = manipulability(plain.robot, dense_path(plain.path, 1e-3))
    above = np.flatnonzero(v >= floor)
    assert not len(above) or v[above[0] : above[-1]].min() < floor


def test_w_of_zero_between_two_samples_is_seen() -> None:
    """The elbow of a planar arm goes straight: w = 0 there, above the floor at the nearest samples on either side."""
    robot = load("planar_2r")
    through = np.array([[0.1, -0.90033], [0.0, -0.70033], [0.3, 0.9]])
    assert manipulability(robot, dense_path(through, 1e-3)).min() > 1e-5
    assert find_violation(robot, through, 1e-5) == 1
    assert find_violation(robot, through[:2], 1e-5) is None
    for before in (4e-4, 5e-5):  # low at a corner, zero on the segment after it
        corner = np.array([[0.0, -0.5], [0.0, -before], [0.0, 0.5]])
        assert find_violation(robot, corner, 0.02 * before) == 1


# the highest floor


@cache
def dense_minima() -> np.ndarray:
    """The smallest w on every edge of the post's roadmap, at 400 states."""
    a, b = (post_roadmap().nodes[rows] for rows in post_roadmap().edges.T)
    states = a[:, None] + np.linspace(0, 1, 400)[:, None] * (b - a)[:, None]
    return manipulability(load("planar_2r"), states.reshape(-1, 2)).reshape(len(a), -1).min(axis=1)


@QUICK
@given(st.integers(0, 2**31), st.booleans())
def test_the_highest_floor_is_that_of_the_widest_path_by_floyd_and_warshall(seed: int, directed: bool) -> None:
    rng, n = np.random.default_rng(seed), 60
    start, goal = rng.choice(n, 2, replace=False)
    roadmap = replace(post_roadmap(), starts=np.array([start]), goals=np.array([goal]))
    network = build_network(roadmap)
    if directed:
        network = network.without_arcs(np.flatnonzero(rng.random(network.n_arcs) < 0.5))
    width = np.full((n, n), -1.0)
    rows = edge_rows(roadmap, network.tails, network.indices)
    width[network.tails, network.indices] = dense_minima()[rows]
    for k in range(n):
        width = np.maximum(width, np.minimum(width[:, k, None], width[k]))
    widest, floor = width[start, goal], highest_floor(load("planar_2r"), roadmap, network)
    if widest < 0:
        assert floor == 0.0
    else:
        assert 0.85 * widest - 0.01 <= floor <= widest + 0.01
