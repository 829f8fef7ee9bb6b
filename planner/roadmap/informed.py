"""Informed samples and lazily proven links: they fill a roadmap where cheaper paths may pass."""

import math

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, product
from planner.kinematics.manipulability import manipulability
from planner.native.compiled import cheapest_path
from planner.roadmap.connections import find_nearest
from planner.roadmap.refine import PathRefiner, split_evenly
from planner.robot.robot import Robot

_SAMPLES = 64  # per call, half of them in a tube around the best path, a quarter around its ends
_TUBE, _BALL = (0.05, 0.5), (0.05, 1.5)  # rad: the range of the random radius
_DRAWS = 20  # per sample within the joint limits
_UPHILL, _STEP = 10, 0.1  # most steps up the gradient of w, and their length (rad)
_EPS = 1e-3  # rad, finite differences
_ROUNDING = 1e-9  # relative: a straight path is as long as the distance of its ends
_NEAR = 0.75  # rad: the distance within which paths count as alike
_LIKENESS = 2.0  # share of a motion's cost that is added if it is like a former path


class LazyRoadmap:
    """A roadmap's proven edges, and samples with links that are proven once a path uses them (LazyPRM*).

    Every sample is linked to its k nearest nodes with k of PRM*, k = e (1 + 1 / dof) log n: as samples fill the
    informed set, the cheapest path converges to the optimum (Karaman and Frazzoli 2011).
    """

    def __init__(self, refiner: PathRefiner, nodes: Floats, edges: Ints, starts: Ints, goals: Ints) -> None:
        self._refiner, self._starts, self._goals = refiner, starts, goals
        self.starts, self.goals = nodes[starts], nodes[goals]
        self._robot: Robot = refiner.prover.robot
        self._bound = refiner.prover.checker.bound
        self.nodes, self._links = nodes, np.zeros((0, 2), dtype=np.int64)
        self._cost, self._proven = np.zeros(0), np.zeros(0, dtype=bool)
        self._back = np.zeros(0, dtype=np.int64)  # the row of each link in the other direction
        self._penalty = np.ones(len(nodes))
        self._link(edges, proven=True)

    def add(self, samples: Floats) -> None:
        """Add the free ones of ``samples`` (k, dof), each with links to its nearest nodes."""
        samples = samples[manipulability(self._robot, samples) >= self._refiner.cost.objective.floor]
        if constraints := self._refiner.prover.world.constraints:
            samples, allowed = constraints.project(samples)
            samples = self._robot.normalise(samples[allowed])
        free = samples[self._bound.is_each_clear(samples)]
        first = len(self.nodes)
        self._add_nodes(free)
        count = math.ceil(math.e * (1.0 + 1.0 / self._robot.dof) * math.log(max(len(self.nodes), 2)))
        # each is its own nearest node
        _, near = find_nearest(self._robot, self.nodes, free, min(count + 1, len(self.nodes)))
        pairs = np.stack(np.broadcast_arrays(near, np.arange(first, len(self.nodes))[:, None]), axis=2).reshape(-1, 2)
        pairs = np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)
        self._link(pairs, proven=False)

    def add_path(self, path: Floats) -> None:
        """Add a ``path`` (k, dof) from a start to a goal, which are nodes; its motions are proven like links."""
        first, inner = len(self.nodes), path[1:-1]
        _, ends = find_nearest(self._robot, self.nodes, path[[0, -1]], 1)
        rows = np.array([ends[0, 0], *range(first, first + len(inner)), ends[1, 0]])
        self._add_nodes(inner)
        self._link(np.column_stack([rows[:-1], rows[1:]]), proven=False)

    def _add_nodes(self, nodes: Floats) -> None:
        self.nodes = np.vstack([self.nodes, nodes])
        self._penalty = np.concatenate([self._penalty, np.ones(len(nodes))])

    def _link(self, links: Ints, proven: bool) -> None:
        """Add ``links`` (m, 2), which cost the same in both directions."""
        a = self.nodes[links[:, 0]]
        cost = self._refiner.cost(a, a + self._robot.difference(a, self.nodes[links[:, 1]]))
        finite = np.isfinite(cost)
        links, cost = links[finite], cost[finite]
        row = len(self._links) + np.arange(len(links))
        self._back = np.concatenate([self._back, row + len(links), row])
        self._links = np.concatenate([self._links, links, links[:, ::-1]])
        self._cost = np.concatenate([self._cost, cost, cost])
        self._proven = np.concatenate([self._proven, np.full(2 * len(links), proven)])

    def penalise(self, path: Floats) -> None:
        """Raise the cost of paths like this one in searches for another kind."""
        away, _ = find_nearest(self._robot, split_evenly(path, 0.5 * _NEAR), self.nodes, 1)
        self._penalty += _LIKENESS * (away[:, 0] < _NEAR)

    def cheapest_path(self, other: bool = False) -> Floats | None:
        """Return the cheapest path (k, dof) of proven motions, unwound; with ``other`` one of another kind."""
        weight, (tail, head) = self._cost.copy(), self._links.T
        if other:
            weight *= 0.5 * (self._penalty[tail] + self._penalty[head])
        while not self._refiner.progress.stopped:
            rows, used = cheapest_path(len(self.nodes), self._links, weight, self._starts, self._goals)
            if not len(rows):
                return None
            new = used[~self._proven[used]]
            if not len(new):
                return self._robot.unwound(self.nodes[rows])
            a = self.nodes[tail[new]]
            free = self._refiner.prove(a, a + self._robot.difference(a, self.nodes[head[new]]))
            for links in (new, self._back[new]):
                self._proven[links[free]] = True
                weight[links[~free]] = self._cost[links[~free]] = np.inf
        return None


def sample_informed_set(
    refiner: PathRefiner, path: Floats, rate: float, rng: np.random.Generator, count: int = _SAMPLES
) -> Floats:
    """Return about ``count`` configurations (k, dof) that a path cheaper than ``path`` may pass.

    They are within limits. Half of them lie near ``path``, a quarter near its ends, the others uniformly in the
    informed set: at a cost of ``rate`` per rad at least, a path through q costs ``rate`` (|q - start| + |goal - q|) or
    more, so q lies in an ellipsoid (Gammell, Srinivasa, Barfoot, Informed RRT*, 2014), or in one of several where
    joints turn freely. With ``rate`` 0 that is everywhere. Where w counts every second sample walks uphill in w first,
    above a floor all of them do: good paths lie near the ridges of w.
    """
    robot = refiner.prover.robot
    half, quarter = count // 2, count // 4
    tube = _sample_near(split_evenly(path, 0.05), half, _TUBE, rng)
    balls = _sample_near(path[[0, -1]], quarter, _BALL, rng)
    longest = refiner.total(path) / rate if rate > 0 else np.inf
    goal = _choose_goal_turn(robot, path[0], path[-1], longest, rng)
    drawn = _sample_ellipsoid(robot, path[0], goal, longest, _DRAWS * quarter, rng)
    samples = np.concatenate([tube, balls, drawn[_is_within_limits(robot, drawn)][:quarter]])
    if refiner.cost.objective.floor > 0:
        samples = _climb(robot, samples, rng)
    elif refiner.cost.objective.beta < 1.0:
        samples[::2] = _climb(robot, samples[::2], rng)
    return robot.normalise(samples[_is_within_limits(robot, samples)])


def _climb(robot: Robot, q: Floats, rng: np.random.Generator) -> Floats:
    """Return the states (k, dof) after walks up the gradient of w of random lengths, within limits."""
    q, dof, steps = q.copy(), q.shape[1], rng.integers(1, _UPHILL + 1, size=len(q))
    for step in range(_UPHILL):
        rows = np.flatnonzero(steps > step)
        probes = np.concatenate([q[rows, None], q[rows, None] + _EPS * np.eye(dof)], axis=1)
        w = manipulability(robot, probes.reshape(-1, dof)).reshape(-1, dof + 1)
        slope = w[:, 1:] - w[:, :1]
        uphill = slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-300)
        there = q[rows] + _STEP * uphill
        q[rows] = np.where(robot.continuous, there, np.clip(there, robot.lower, robot.upper))
    return q


def _sample_near(points: Floats, count: int, radius: tuple[float, float], rng: np.random.Generator) -> Floats:
    """Return samples (count, dof) at a random distance within ``radius`` of the ``points`` (k, dof)."""
    apart = rng.uniform(*radius, size=(count, 1)) / np.sqrt(points.shape[1])
    return points[rng.integers(0, len(points), size=count)] + apart * rng.normal(size=(count, points.shape[1]))


def _is_within_limits(robot: Robot, q: Floats) -> Bools:
    inside = ((q >= robot.lower) & (q <= robot.upper)) | robot.continuous
    return np.asarray(inside.all(axis=1))


def _choose_goal_turn(robot: Robot, start: Floats, goal: Floats, longest: float, rng: np.random.Generator) -> Floats:
    """Return ``goal`` (dof,) plus whole turns of continuous joints, drawn by the volume of the ellipsoids.

    Only goals within ``longest`` of ``start`` count.
    """
    near, reach = robot.difference(start, goal), (1.0 + _ROUNDING) * longest
    ways = near[None]
    for joint in np.flatnonzero(robot.continuous) if math.isfinite(longest) else ():
        other = ways.copy()
        other[:, joint] -= math.copysign(2.0 * math.pi, near[joint])
        ways = np.vstack([ways, other])
        ways = ways[np.linalg.norm(ways, axis=1) <= reach]
    if len(ways) < 2:
        return goal
    squares = reach**2 - (ways * ways).sum(axis=1)
    volume = np.cumsum([math.pow(max(each, 0.0), 0.5 * (robot.dof - 1)) for each in squares.tolist()])
    return start + ways[np.searchsorted(volume, rng.random() * volume[-1])]


def _sample_ellipsoid(
    robot: Robot, start: Floats, goal: Floats, longest: float, count: int, rng: np.random.Generator
) -> Floats:
    """Return points (count, dof) uniform in the ellipsoid with these foci, or in the limits if smaller."""
    axis, dof = goal - start, len(start)
    apart = float(np.linalg.norm(axis, axis=0))
    if longest >= apart + 2.0 * float((robot.upper - robot.lower).max()) or apart == 0.0:
        return rng.uniform(robot.lower, robot.upper, size=(count, dof))
    ball = rng.normal(size=(count, dof))
    radius = np.array([math.pow(share, 1.0 / dof) for share in rng.random(count).tolist()])  # the same bits everywhere
    ball *= radius[:, None] / np.linalg.norm(ball, axis=1, keepdims=True)
    ball *= 0.5 * np.sqrt(max(longest**2 - apart**2, 0.0))
    ball[:, 0] *= longest / np.sqrt(max(longest**2 - apart**2, 1e-300))
    mirror = axis / apart - np.eye(dof)[0]  # Householder: takes the first axis to that of the ellipsoid
    size = float((mirror * mirror).sum())
    if size > 0:
        ball = ball - (2.0 / size) * product(ball, mirror)[:, None] * mirror
    return 0.5 * (start + goal) + ball
