"""Refinement of a path by proven motions: shortcuts, partial shortcuts, and descent.

Three moves, alternately. Shortcuts: the cheapest chain of proven motions through points of the path, which drops every
waypoint that does not pay. Partial shortcuts: on a section of the path some joints move evenly and the others keep
their motion (Geraerts and Overmars, Creating high-quality paths for motion planning, 2007). Descent: every second
waypoint moves downhill in cost, or at random near that direction, so that it slides along obstacles.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from planner.base import arrays
from planner.base.arrays import Bools, Floats, Ints, cumulative_sums
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import PROOF, W_ALONG_PATH
from planner.collision import path_moves
from planner.collision.edge_prover import EdgeProver, MotionTest
from planner.collision.path_moves import cheapest_chain, first_free, straighten
from planner.cost.motion_cost import MotionCost
from planner.kinematics.manipulability import manipulability
from planner.native.refinement import Descent, EvenStretches, Step

_CORNER, _ROUNDS_PER_CORNER = 0.004, 6  # share of the cost charged per waypoint, a third of it after so many rounds
_ROUNDING = (0.02, 0.6)  # rad: the distance from a corner of points that cut it
_LEAST_GAIN = 1e-4  # relative: less is not worth a proof
_POINTS = 40  # most points of a path among which shortcuts are searched
_SHORT, _LONG = 0.5, 1.0  # rad: the spacing of points for shortcuts, and for descent
_STRETCHES, _PROVEN_STRETCHES = 12, 2  # per try of partial shortcuts
_SWEEPS = 12  # of descent; each moves every second waypoint
_FIRST_STEP, _LEAST_STEP = 0.3, 0.02  # rad
# shares of a step downhill, and of the way to the middle of the neighbours, which is downhill in length
_MIXES = np.array([[1.0, 0], [0.5, 0], [0.25, 0], [0.1, 0], [0, 1.0], [0, 0.5], [0.5, 0.5], [0.25, 0.5]])
_RANDOM, _SPREAD = 6, 1.4  # random directions per waypoint; length of the addition to the downhill one, of length 1
_PROVEN_PER_WAYPOINT = 3  # best candidates that are proven
_ENDLESS = 1e6  # replaces an infinite cost, of motions on which w falls below the floor
_STRAIGHT = 1e-3  # rad: a smaller change of direction is no corner


@dataclass(eq=False)
class PathRefiner:
    """Makes paths of proven motions cheaper under ``cost``; proofs have ``resolution`` (m).

        refiner = PathRefiner(prover, MotionCost(robot, scale, Objective()))
        path = refiner.round(path)                     # again and again, until it gains nothing

    Paths are (k, dof), angles unwound, their ends stay. On new motions w, sampled ``W_ALONG_PATH`` apart, stays above
    ``floor`` and that of the cost. The same ``seed`` gives the same paths.
    """

    prover: EdgeProver
    cost: MotionCost
    resolution: float = PROOF
    seed: int = 0
    progress: Progress = QUIET
    tries: int = 16  # partial shortcuts per round
    floor: float = 0.0
    _rng: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)
        self.floor = max(self.floor, self.cost.objective.floor)

    def total(self, path: Floats) -> float:
        """Return the cost of a path."""
        return float(self.cost(path[:-1], path[1:]).sum())

    def round(self, path: Floats, number: int = 0) -> Floats:
        """Return the path after one round of all three moves; the same path if they gain nothing.

        A waypoint has a cost of its own, so that few remain; it is smaller in a round of higher ``number``.
        """
        corner = self._corner(path, number)
        moved = self.shortcut(self._add_corner_points(split_evenly(path, _SHORT, _POINTS)), corner / 3)
        moved = self.partial_shortcuts(moved)
        moved = self.shortcut(moved, corner)
        moved = self.descend(self._add_corner_points(split_evenly(moved, _LONG, _POINTS)))
        moved = self.shortcut(moved, corner)
        if self.progress.stopped:
            return path
        better = self.total(moved) + corner * len(moved) < self.total(path) + corner * len(path)
        return moved if better else path

    def finish(self, path: Floats, number: int = 0) -> Floats:
        """Return the path after a last descent, without the waypoints that gain too little."""
        return self.shortcut(self.descend(path), self._corner(path, number))

    def _corner(self, path: Floats, number: int) -> float:
        return _CORNER * self.total(path) / 3.0 ** (number // _ROUNDS_PER_CORNER)

    def shortcut(self, points: Floats, corner: float) -> Floats:
        """Return the cheapest chain of proven motions through some of ``points`` (k, dof).

        Motions between consecutive points are proven already. Each motion is charged ``corner`` and its cost. Motions
        are proven only once a cheapest chain uses them.
        """
        k = len(points)
        if k < 3:
            return points
        return points[cheapest_chain(self.prover, points, self._pairs(points, corner), self.resolution, self._test)]

    def partial_shortcuts(self, path: Floats) -> Floats:
        """Return the path after ``tries`` tries, each the best of a few sections with evenly moving joints."""
        points = split_evenly(path, _SHORT, _POINTS)
        if len(points) < 3:
            return path
        stretches = EvenStretches(points, *self._stretches(*points.shape), _LEAST_GAIN, _PROVEN_STRETCHES)
        return straighten(self.prover, self.cost.charge, stretches, self.resolution, self._test)

    def first_free_alternatives(self, start: Floats, end: Floats, motions: Ints, alternatives: Ints) -> Ints:
        """Return for each item its first alternative whose motions from ``start`` to ``end`` all pass.

        See :func:`planner.collision.path_moves.first_free`.
        """
        return first_free(self.prover, start, end - start, motions, alternatives, self.resolution, self._test)

    def prove(self, a: Floats, b: Floats) -> Bools:
        """Return (k,) whether the motions from ``a`` to ``b`` (k, dof) are proven and stay above the floor."""
        free = self.prover.free(a, b - a, self.resolution)
        if self._test is not None:
            free[free] = self._test(a[free], (b - a)[free])
        return free

    @property
    def _test(self) -> MotionTest | None:
        """The test that motions must pass besides their proof."""
        return self._is_above_floor if self.floor > 0 else None

    def _is_above_floor(self, start: Floats, delta: Floats) -> Bools:
        """Return (k,) whether w is above the floor along the motions from ``start`` by ``delta`` (k, dof)."""
        above = np.ones(len(start), dtype=bool)
        for row in range(len(start)):
            count = max(1, int(np.ceil(np.abs(delta[row]).max() / W_ALONG_PATH)))
            states = start[row] + np.linspace(0.0, 1.0, count + 1)[:, None] * delta[row]
            above[row] = (manipulability(self.prover.robot, states) >= self.floor).all()
        return above

    def _add_corner_points(self, path: Floats) -> Floats:
        """Return the path with two more points at each corner, at equal distances before and after it."""
        step = np.diff(path, axis=0)
        far = np.linalg.norm(step, axis=1)
        ahead = step / np.maximum(far, 1e-300)[:, None]
        turns = np.linalg.norm(np.diff(ahead, axis=0), axis=1) > _STRAIGHT
        # NumPy's own exp has other last bits on other processors
        reach = np.array([math.exp(r) for r in self._rng.uniform(*map(math.log, _ROUNDING), size=len(turns)).tolist()])
        rows = [path[:1]]
        for k, turn in enumerate(turns):
            near = min(reach[k], 0.45 * far[k], 0.45 * far[k + 1])
            here = path[k + 1 : k + 2]
            rows += [here - near * ahead[k], here, here + near * ahead[k + 1]] if turn else [here]
        return np.concatenate([*rows, path[-1:]])

    def _pairs(self, points: Floats, corner: float) -> Floats:
        """Return (k, k) prices of the forward motions between points; infinite unless cheaper than the path."""
        k = len(points)
        i, j = np.triu_indices(k, 1)
        cost = self.cost(points[i], points[j])
        along = cumulative_sums(np.minimum(cost[j == i + 1], _ENDLESS))  # a difference of infinite costs is NaN
        pays = (j == i + 1) | (cost + corner < along[j] - along[i] + corner * (j - i))
        price = np.full((k, k), np.inf)
        price[i, j] = np.where(pays, cost + corner, np.inf)
        return price

    def _stretches(self, count: int, dof: int) -> tuple[Ints, Bools, Floats]:
        """Return random sections of a path of ``count`` rows, k per try, by their ends (tries, k, 2).

        Then the joints (tries, k, dof) that move evenly, and the share (tries, k) of the change towards that.
        """
        rng, shape = self._rng, (self.tries, _STRETCHES)
        first = rng.integers(0, count - 2, size=shape)
        ends = np.stack([first, rng.integers(first + 2, count)], axis=2)
        joints = rng.random((*shape, dof)) < rng.uniform(0.1, 0.6, size=(*shape, 1))
        joints |= rng.integers(dof, size=(*shape, 1)) == np.arange(dof)
        return ends, joints, np.where(rng.random(shape) < 2.0 / 3.0, 1.0, 0.5)

    def descend(self, path: Floats) -> Floats:
        """Return the path after its waypoints moved downhill; steps shrink where few of them gain."""
        if len(path) < 3:
            return path
        dof, shape = path.shape[1], (_SWEEPS, (len(path) - 1) // 2, _RANDOM)
        offset = _SPREAD * self._rng.normal(size=(*shape, dof)) / np.sqrt(dof)
        draws = np.concatenate([offset, self._rng.uniform(0.2, 1.0, size=(*shape, 1))], axis=3)
        robot = self.prover.robot
        limits = robot.lower, robot.upper
        descent = Descent(
            path, 1, Step(_FIRST_STEP), _LEAST_STEP, _LEAST_GAIN, limits, _MIXES, draws, _PROVEN_PER_WAYPOINT
        )
        return path_moves.descend(self.prover, self.cost.charge, descent, self.resolution, self._test)


def split_evenly(path: Floats, longest: float, most: int | None = None) -> Floats:
    """Return the path with no motion longer than ``longest`` (rad): part of a proven motion is proven.

    ``longest`` grows where the path would have more than ``most`` points.
    """
    length = arrays.lengths_of(path)
    if most is not None:
        longest = max(longest, float(length.sum()) / max(most - len(path), 1))
    return arrays.cut(path, arrays.parts_of(length, longest))


TOLERANCE = 1e-3  # share of the cost by which a path with fewer corners may be costlier
_OUTWARD = (0.0, 0.3, 0.7, 1.2)  # candidates beyond the point where the neighbouring motions would meet
_RANDOM_CANDIDATES = 24  # candidates around these
_PROVEN = 48  # candidates of all pairs whose motions are proven


def simplify(refiner: PathRefiner, path: Floats, rng: np.random.Generator) -> Floats:
    """Return the path with the fewest waypoints found for 1 + ``TOLERANCE`` times its cost at most.

    Its ends stay, its motions are proven and above the floor of the cost. A path of infinite cost, below the floor,
    stays unchanged.
    """
    limit = (1.0 + TOLERANCE) * refiner.total(path)
    while len(path) > 3 and np.isfinite(limit) and not refiner.progress.stopped:
        shorter = _merge_pair(refiner, path, limit, rng)
        if shorter is None:
            break
        path = refiner.descend(shorter)
    return path


def _merge_pair(refiner: PathRefiner, path: Floats, limit: float, rng: np.random.Generator) -> Floats | None:
    """Return the path with the pair of neighbouring waypoints merged that is cheapest to merge, or None."""
    a, p, q, b = path[:-3], path[1:-2], path[2:-1], path[3:]
    robot, places = refiner.prover.robot, _candidates(a, p, q, b, rng)
    places = np.where(robot.continuous, places, np.clip(places, robot.lower, robot.upper))
    count = places.shape[1]
    flat = places.reshape(-1, robot.dof)
    before, after = np.repeat(a, count, axis=0), np.repeat(b, count, axis=0)
    step = refiner.cost(path[:-1], path[1:])
    rise = refiner.cost(before, flat) + refiner.cost(flat, after) - np.repeat(step[:-2] + step[1:-1] + step[2:], count)
    order = np.argsort(rise, kind="stable")
    order = order[step.sum() + rise[order] <= limit][:_PROVEN]
    start = np.stack([before[order], flat[order]], axis=1).reshape(-1, robot.dof)
    end = np.stack([flat[order], after[order]], axis=1).reshape(-1, robot.dof)
    best = refiner.first_free_alternatives(start, end, np.full(len(order), 2), np.array([len(order)]))[0]
    if best < 0:
        return None
    row = order[best]
    pair = row // count
    return np.concatenate([path[: pair + 1], flat[row : row + 1], path[pair + 3 :]])


def _candidates(a: Floats, p: Floats, q: Floats, b: Floats, rng: np.random.Generator) -> Floats:
    """Return waypoints (k, candidates, dof) that might replace ``p`` and ``q``, between ``a`` and ``b``."""
    middle, meeting = 0.5 * (p + q), _meeting(a, p, q, b)
    places = [p, q, middle, *(meeting + share * (meeting - middle) for share in _OUTWARD)]
    size = 0.5 * (
        np.linalg.norm(q - p, axis=1, keepdims=True) + np.linalg.norm(meeting - middle, axis=1, keepdims=True)
    )
    for _ in range(_RANDOM_CANDIDATES):
        around = middle + rng.uniform(0.0, 1.5) * (meeting - middle)
        places.append(around + rng.uniform(0.1, 0.7) * size * rng.normal(size=p.shape) / np.sqrt(p.shape[1]))
    return np.stack(places, axis=1)


def _meeting(a: Floats, p: Floats, q: Floats, b: Floats) -> Floats:
    """Return the midpoint of the nearest points of the lines a p and b q, extended beyond p and q.

    They are extended by at most the distance of ``p`` and ``q``.
    """
    u, v = (ahead / np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-300) for ahead in (p - a, q - b))
    w, most = q - p, np.linalg.norm(q - p, axis=1)
    uv, uw, vw = ((one * other).sum(axis=1) for one, other in ((u, v), (u, w), (v, w)))
    level = np.maximum(1.0 - uv * uv, 1e-9)
    s, t = (np.clip(far, 0.0, most)[:, None] for far in ((uw - uv * vw) / level, (uv * uw - vw) / level))
    return 0.5 * (p + s * u + q + t * v)
