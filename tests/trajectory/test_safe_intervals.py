"""Safe-interval search against a search of every moment, and what it takes for free against FCL."""

from collections import defaultdict
from types import SimpleNamespace

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.checker import CollisionChecker, is_free
from planner.collision.fcl import FclChecker
from planner.collision.timed_prover import TimedProver, moving_world
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle, Shape
from planner.trajectory.limits import MotionLimits
from planner.trajectory.safe_intervals import (
    RoadmapInTime,
    earliest_route,
    rest_to_rest_seconds,
)
from planner.trajectory.trajectory import Trajectory
from tests.worlds import load, post_roadmap

LAST = 30  # s: what moves stands still from then on


class Drawn:
    """A graph with drawn times in whole seconds, as :class:`RoadmapInTime` has them."""

    def __init__(self, seed: int, nodes: int = 8) -> None:
        rng = np.random.default_rng(seed)
        self.seconds = rng.integers(1, 5, 3 * nodes).astype(float)
        self.neighbours: list[list[tuple[int, int]]] = [[] for _ in range(nodes)]
        ends = [rng.choice(nodes, 2, replace=False) for _ in range(3 * nodes)]
        self.roadmap = SimpleNamespace(edges=np.array(ends))
        for edge, (i, j) in enumerate(self.roadmap.edges.tolist()):
            self.neighbours[i].append((j, edge))
            self.neighbours[j].append((i, edge))
        self._stays = [self._draw(rng, 0.7) for _ in range(nodes)]
        self._windows = defaultdict(lambda: self._draw(rng, 0.4))

    @staticmethod
    def _draw(rng: np.random.Generator, share: float) -> np.ndarray:
        """Drawn seconds joined to stretches; the last one has no end."""
        free = np.append(rng.random(LAST) < share, True)
        change = np.flatnonzero(np.diff(np.concatenate([[False], free, [False]])))
        found = change.reshape(-1, 2).astype(float)
        found[-1, 1] = np.inf
        return found

    def rest_intervals(self, node: int, until: float = np.inf) -> np.ndarray:
        found = self._stays[node]
        return np.minimum(found[found[:, 0] < until], until)

    def safe_from(self, node: int) -> float:
        return self._stays[node][-1, 0]

    def departure_intervals(self, i: int, edge: int, until: float = np.inf) -> np.ndarray:
        return self._windows[i, edge]

    def horizons(self, least: float) -> list[float]:
        return [until for until in (2.0, 4.0, 8.0, 16.0, np.inf) if until >= least]


def holds(stretches: np.ndarray, low: float, high: float) -> bool:
    return bool(((stretches[:, 0] <= low) & (high <= stretches[:, 1])).any())


def earliest_of_all_moments(timed: Drawn, start: int, goal: int) -> float:
    """Every second at every node: which can be stood at, and which edges begun; stretches begin and end at seconds."""
    reached = {start} if holds(timed.rest_intervals(start), 0, 0) else set()
    coming = defaultdict(set)
    for now in range(3 * LAST):
        reached |= coming[now]
        if goal in reached and holds(timed.rest_intervals(goal), now, np.inf):
            return now
        for i in reached:
            for j, edge in timed.neighbours[i]:
                then = now + int(timed.seconds[edge])
                if holds(timed.departure_intervals(i, edge), now, now) and holds(timed.rest_intervals(j), then, then):
                    coming[then].add(j)
        reached = {i for i in reached if holds(timed.rest_intervals(i), now, now + 1)}
    return np.inf


@pytest.mark.parametrize("seed", range(20))
def test_the_route_is_the_earliest_of_all(seed: int) -> None:
    timed = Drawn(seed)
    route = earliest_route(timed, np.array([0]), np.array([7]))
    best = earliest_of_all_moments(timed, 0, 7)
    if route is None:
        assert best == np.inf
        return
    assert route.arrivals[-1] == best
    for k, (i, j) in enumerate(zip(route.nodes[:-1].tolist(), route.nodes[1:].tolist(), strict=True)):
        leaves, arrives = route.departures[k], route.arrivals[k + 1]
        assert holds(timed.rest_intervals(i), route.arrivals[k], leaves)
        edges = [e for other, e in timed.neighbours[i] if other == j and leaves + timed.seconds[e] == arrives]
        assert any(holds(timed.departure_intervals(i, e), leaves, leaves) for e in edges)


def test_some_drawn_routes_wait_and_some_are_none() -> None:
    routes = [earliest_route(Drawn(seed), np.array([0]), np.array([7])) for seed in range(20)]
    assert any(route is None for route in routes)
    assert any(route is not None and route.waits.any() for route in routes)


def test_a_motion_of_least_jerk_reaches_one_limit_and_exceeds_none() -> None:
    robot = load("iiwa14")
    limits = MotionLimits.from_robot(robot)
    for delta in np.random.default_rng(0).uniform(-1, 1, (20, robot.dof)) * np.logspace(-3, 0.5, 20)[:, None]:
        takes = float(rest_to_rest_seconds(delta[None], limits)[0])
        rest = np.zeros((2, robot.dof))
        found = Trajectory.from_points(robot.joints, np.array([0, takes]), np.stack([0 * delta, delta]), rest, rest)
        kinds = limits.velocity, limits.acceleration, limits.jerk
        shares = [(found.largest(order) / limit).max() for order, limit in enumerate(kinds, 1)]
        assert 1 - 1e-6 < max(shares) <= 1 + 1e-9


def test_edges_and_stays_are_free_whenever_their_stretches_say_so() -> None:
    checker, roadmap = make_checker(load("planar_2r"), Scene("none"), "coal"), post_roadmap()
    places = [pose([1.2, 0.8, 0]), pose([0.4, -0.3, 0], [0, 0, 1]), pose([-1.5, -1, 0])]
    prover = TimedProver(checker, [MovingObstacle("cart", Box((0.2, 0.3, 0.2)), KnownMotion([0, 2, 5], places))])
    timed = RoadmapInTime(roadmap, prover, MotionLimits.from_robot(load("planar_2r")))
    rng, partly = np.random.default_rng(0), 0
    for edge in rng.choice(len(roadmap.edges), 8, replace=False):
        i, j = roadmap.edges[edge].tolist()
        windows, takes = timed.departure_intervals(i, int(edge), np.inf), float(timed.seconds[edge])
        a, b, rest = roadmap.nodes[i], roadmap.nodes[j], np.zeros((2, 2))
        partly += len(windows) > 1
        for low, high in windows:
            begin = rng.uniform(low, min(high, 6.0))
            run = Trajectory.from_points(("a", "b"), np.array([0, takes]), np.stack([a, b]), rest, rest)
            t = np.linspace(0, takes, 300)
            for q, when in zip(run.at(t)[::30], t[::30], strict=True):
                standing = prover.world.obstacles[0]
                placed = prover.motions["cart"].at(begin + when)[0]
                assert clear(checker, standing.shape, placed, q)
        for low, high in timed.rest_intervals(i, np.inf):
            placed = prover.motions["cart"].at(rng.uniform(low, min(high, 6.0)))[0]
            assert clear(checker, prover.world.obstacles[0].shape, placed, a)
    assert partly > 0


def clear(checker: CollisionChecker, shape: Shape, placement: np.ndarray, q: np.ndarray) -> bool:
    """Whether nothing touches, by FCL."""
    return is_free(FclChecker(moving_world(checker.world, (Obstacle("cart", shape, placement),))), q)
