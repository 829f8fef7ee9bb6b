"""Safe-interval search over a roadmap (SIPP): the earliest arrival among moving obstacles.

Phillips and Likhachev 2011: of all times in one safe interval of a node only the earliest arrival counts, as waiting
leads from there to the later ones. Here the safe intervals, and the intervals in which an edge may start, are
certified: each is a union of cells of time, and every cell is proven as a whole.

A search looks ahead up to a horizon, and is repeated with twice the horizon if it finds nothing. Obstacles that move
later than twice the arrival then cost only the proof that the robot can rest at the goal.
"""

import heapq
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.progress import QUIET, Progress
from planner.collision.timed_prover import TimedProver
from planner.native.compiled import cheapest_costs
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.trajectory.limits import LEAST_JERK, USED, MotionLimits
from planner.trajectory.trajectory import NANOSECOND, Trajectory

LAW = "safe-intervals"
_State: TypeAlias = tuple[int, int]  # a node and the number of one of its intervals
_SHORTEST = 1e-6  # s: a shorter wait is dropped
# least-jerk motion from rest to rest along a line: 10 u^3 - 15 u^4 + 6 u^5
_QUINTIC = np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
_CELL, _FINEST = 0.5, 1 / 64  # s: cells of time are halved from the one down to the other
_FIRST = 32  # cells up to the first horizon

CellProof: TypeAlias = Callable[[Floats, Floats], Bools]  # which cells from low (n,) to high (n,) s are prove


def certify_intervals(prove: CellProof, grid: Floats) -> Floats:
    """Return the proven intervals (k, 2) of the time between ``grid`` (n + 1,), ascending and disjoint.

    The whole time is proven first, then halves of unproven parts, down to cells of 1/64 s.
    """
    first, last = np.array([0]), np.array([len(grid) - 1])
    intervals, single = [np.zeros((0, 2))], []
    while len(first):
        low, high = grid[first], grid[last]
        free = prove(low, high)
        intervals.append(np.column_stack([low, high])[free])
        first, last = first[~free], last[~free]
        single.append(first[last - first == 1])
        first, last = first[last - first > 1], last[last - first > 1]
        middle = (first + last) // 2
        first, last = np.concatenate([first, middle]), np.concatenate([middle, last])
    cells = np.concatenate(single)
    return _merge(np.concatenate([*intervals, _prove_halves(prove, grid[cells], grid[cells + 1])]))


def find_safe_start(prove: CellProof, grid: Floats) -> float:
    """Return the time (s), on or between ``grid`` (n + 1,), after which all is proven, or inf.

    The search starts at the end, and does not split what is proven as a whole.
    """
    if not prove(grid[-1:], grid[-1:])[0]:
        return np.inf
    since, waiting = float(grid[-1]), [(0, len(grid) - 1)]
    while waiting:
        first, last = waiting.pop()
        if first == last:
            continue
        if prove(grid[first : first + 1], grid[last : last + 1])[0]:
            since = float(grid[first])
        elif last - first > 1:
            waiting += [(first, (first + last) // 2), ((first + last) // 2, last)]
        else:
            cells = certify_intervals(prove, grid[first : last + 1])
            return float(cells[-1, 0]) if len(cells) and cells[-1, 1] == since else since
    return since


def _prove_halves(prove: CellProof, low: Floats, high: Floats) -> Floats:
    """Return the proven parts (k, 2) of unproven cells from ``low`` to ``high`` (n,)."""
    intervals = [np.zeros((0, 2))]
    while True:
        wide = high - low > _FINEST
        low, high = low[wide], high[wide]
        if not len(low):
            return np.concatenate(intervals)
        middle = 0.5 * (low + high)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        free = prove(low, high)
        intervals.append(np.column_stack([low, high])[free])
        low, high = low[~free], high[~free]


def _merge(cells: Floats) -> Floats:
    """Return cells (n, 2) with adjacent ones merged."""
    cells = cells[np.argsort(cells[:, 0], kind="stable")]
    if not len(cells):
        return cells
    begins = np.concatenate([[True], cells[1:, 0] > cells[:-1, 1]])
    ends = np.concatenate([begins[1:], [True]])
    return np.column_stack([cells[begins, 0], cells[ends, 1]])


@dataclass(frozen=True, eq=False)
class TimedRoute:
    """Nodes (k,) of a roadmap, with arrival and departure (s) at each; the robot rests at the last one."""

    nodes: Ints
    arrivals: Floats
    departures: Floats

    @property
    def waits(self) -> Floats:
        """(k,) seconds of rest at each node."""
        return self.departures - self.arrivals

    def trajectory(self, roadmap: Roadmap, prover: TimedProver, limits: MotionLimits) -> Trajectory:
        """Return the route as a trajectory: from rest to rest along every edge, with waits at nodes."""
        path = path_waypoints(roadmap, prover.robot, self.nodes)
        waiting_nodes = self.waits > _SHORTEST
        rows = np.repeat(np.arange(len(path)), 1 + waiting_nodes)
        times = np.sort(np.concatenate([self.arrivals, self.departures[waiting_nodes]]))
        if len(path) == 1:
            rows, times = np.zeros(2, dtype=np.int64), np.array([0.0, _SHORTEST])
        rest = np.zeros((len(rows), path.shape[1]))
        return Trajectory.from_points(prover.robot.joints, times, path[rows], rest, rest, time_law=LAW)


class RoadmapInTime:
    """A roadmap with edges run from rest to rest within limits, and a prover of motions in time.

    ``seconds`` (m,) is the duration of each edge. Safe intervals are computed on request, and cached.
    """

    def __init__(self, roadmap: Roadmap, prover: TimedProver, limits: MotionLimits) -> None:
        self.roadmap, self.prover = roadmap, prover
        first, last = (roadmap.nodes[roadmap.edges[:, k]] for k in (0, 1))
        self.seconds = rest_to_rest_seconds(prover.robot.difference(first, last), limits.scale_all(USED))
        self._grid = np.linspace(0.0, prover.end, int(np.ceil(prover.end / _CELL)) + 1)  # later nothing moves
        self._cached: dict[tuple[int, int, float], Floats] = {}
        self.neighbours: list[list[tuple[int, int]]] = [[] for _ in roadmap.nodes]  # (node, edge)
        for row, (i, j) in enumerate(roadmap.edges.tolist()):
            self.neighbours[i].append((j, row))
            self.neighbours[j].append((i, row))

    def rest_intervals(self, node: int, until: float) -> Floats:
        """Return intervals (k, 2) s, up to ``until``, in which rest at a node is proven free."""
        return self._safe_intervals(node, -1, until)

    def departure_intervals(self, node: int, edge: int, until: float) -> Floats:
        """Return intervals (k, 2) s, up to ``until``, in which an ``edge`` from a node may start."""
        return self._safe_intervals(node, edge, until)

    def safe_from(self, node: int) -> float:
        """Return the time (s) from which on rest at a node is proven free for good, or inf."""
        return find_safe_start(self._make_proof(node, -1), self._grid)

    def horizons(self, least: float) -> Iterator[float]:
        """Yield the horizons (s) of searches, each twice the one before; the last one is inf."""
        count = _FIRST
        while count < len(self._grid):
            if self._grid[count] >= least:
                yield float(self._grid[count])
            count *= 2
        yield np.inf

    def _safe_intervals(self, node: int, edge: int, until: float) -> Floats:
        if (node, edge, until) not in self._cached:
            prove, end = self._make_proof(node, edge), self._grid[-1:]
            intervals = certify_intervals(prove, self._grid[self._grid <= until])
            if until > end[0] and prove(end, end)[0]:
                intervals = _merge(np.vstack([intervals, [[end[0], np.inf]]]))
            self._cached[node, edge, until] = intervals
        return self._cached[node, edge, until]

    def _make_proof(self, node: int, edge: int) -> CellProof:
        """Return the proof of cells in which the robot rests at a node, or starts an ``edge`` there."""
        start, takes = self.roadmap.nodes[node], 0.0
        if edge < 0:
            motion = np.stack([start, 0.0 * start])
        else:
            takes = float(self.seconds[edge])
            other = int(self.roadmap.edges[edge].sum()) - node
            motion = _QUINTIC[:, None] * self.prover.robot.difference(start, self.roadmap.nodes[other])
            motion[0] = start

        def prove(low: Floats, high: Floats) -> Bools:
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
            spans = [middle, np.full_like(low, takes), half] if edge >= 0 else [low, high - low, 0.0 * low]
            return self.prover.free(np.repeat(motion[None], len(low), axis=0), np.column_stack(spans))

        return prove


def rest_to_rest_seconds(delta: Floats, limits: MotionLimits) -> Floats:
    """Return the seconds (n,) of straight least-jerk motions (n, dof) within limits, from rest to rest.

    Whole nanoseconds plus one: start and end are rounded to nanoseconds.
    """
    size = np.abs(delta)
    kinds = limits.velocity, limits.acceleration, limits.jerk
    pairs = enumerate(zip(LEAST_JERK, kinds, strict=True), 1)
    shares = [(most * size / limit) ** (1 / order) for order, (most, limit) in pairs]
    return (np.ceil(np.max(shares, axis=(0, 2), initial=1e-3) / NANOSECOND) + 1.0) * NANOSECOND


def earliest_route(timed: RoadmapInTime, starts: Ints, goals: Ints, progress: Progress = QUIET) -> TimedRoute | None:
    """Return the route that first reaches one of ``goals`` and can rest there for good, or None.

    It leaves one of ``starts`` at time 0 or later. It is the earliest over the certified intervals; free time too short
    to be proven in cells of 1/64 s is not used. None also after a request to stop.
    """
    safe_since: dict[int, float] = {}
    for goal in goals.tolist():
        if not progress.stopped and np.isfinite(since := timed.safe_from(goal)):
            safe_since[goal] = since
    edges, safe_goals = timed.roadmap.edges, frozen(sorted(safe_since), np.int64)
    both_ways = np.concatenate([edges, edges[:, ::-1]]), np.tile(timed.seconds, 2)
    time_to_go = cheapest_costs(
        len(timed.neighbours), *both_ways, safe_goals, np.zeros(len(safe_goals))
    )  # s, with nothing in the way
    usable = [start for start in dict.fromkeys(starts.tolist()) if np.isfinite(time_to_go[start])]
    if not safe_since or not usable:
        return None
    for horizon in timed.horizons(max(min(safe_since.values()), float(time_to_go[usable].min()))):
        search = _Search(timed, safe_since, time_to_go, horizon)
        route = search.run(usable, progress)
        if route is not None or progress.stopped or not search.cut:
            return route
    return None


@dataclass(eq=False)
class _Search:
    """A search up to a ``horizon`` (s) for goals where rest is safe from ``safe_since`` on, s by node.

    ``time_to_go`` (n,) s: to the nearest goal without obstacles. ``cut``: a larger horizon may allow more.
    """

    timed: RoadmapInTime
    safe_since: dict[int, float]
    time_to_go: Floats
    horizon: float
    cut: bool = False
    arrival: dict[_State, float] = field(default_factory=dict)
    before: dict[_State, tuple[_State, float]] = field(default_factory=dict)

    def run(self, starts: list[int], progress: Progress) -> TimedRoute | None:
        queue: list[tuple[float, float, _State]] = []
        for start in starts:
            if len(intervals := self.timed.rest_intervals(start, self.horizon)) and intervals[0, 0] == 0.0:
                self.arrival[(start, 0)] = 0.0
                heapq.heappush(queue, (float(self.time_to_go[start]), 0.0, (start, 0)))
        while queue and not progress.stopped:
            _, now, state = heapq.heappop(queue)
            node, interval = state
            if now > self.arrival[state]:
                continue
            end = float(self.timed.rest_intervals(node, self.horizon)[interval, 1])
            if node in self.safe_since and self.safe_since[node] <= end:
                return _route(state, self.arrival, self.before)
            for reached, departure, at in self._moves(node, now, end):
                if at < self.arrival.get(reached, np.inf):
                    self.arrival[reached], self.before[reached] = at, (state, departure)
                    heapq.heappush(queue, (at + float(self.time_to_go[reached[0]]), at, reached))
        return None

    def _moves(self, node: int, now: float, end: float) -> Iterator[tuple[_State, float, float]]:
        """Yield the states that one edge reaches, with departure in [``now``, ``end``] and arrival."""
        for other, edge in self.timed.neighbours[node]:
            if np.isinf(self.time_to_go[other]):
                continue
            takes = float(self.timed.seconds[edge])
            latest = min(end, self.horizon - takes - float(self.time_to_go[other]))
            self.cut = self.cut or latest < end or end == self.horizon < np.inf
            if now > latest:
                continue
            for k, low, high in self._useful_intervals(other, takes, now, latest):
                open_ = self.timed.departure_intervals(node, edge, self.horizon)
                row = int(np.searchsorted(open_[:, 1], low))
                departure = max(low, float(open_[row, 0])) if row < len(open_) else np.inf
                if departure <= high:
                    yield (other, k), departure, departure + takes

    def _useful_intervals(
        self, other: int, takes: float, now: float, latest: float
    ) -> Iterator[tuple[int, float, float]]:
        """Yield safe intervals of a node with an earlier arrival than known, and the departures to them.

        Departures lie in [``now``, ``latest``].
        """
        intervals = self.timed.rest_intervals(other, self.horizon)
        low, high = np.maximum(now, intervals[:, 0] - takes), np.minimum(latest, intervals[:, 1] - takes)
        for k in np.flatnonzero(low <= high).tolist():
            if low[k] + takes < self.arrival.get((other, k), np.inf):
                yield k, float(low[k]), float(high[k])


def _route(last: _State, arrival: dict[_State, float], before: dict[_State, tuple[_State, float]]) -> TimedRoute:
    states, departures = [last], [arrival[last]]
    while states[-1] in before:
        state, departure = before[states[-1]]
        states.append(state)
        departures.append(departure)
    nodes = frozen([node for node, _ in states[::-1]], np.int64)
    return TimedRoute(nodes, frozen([arrival[state] for state in states[::-1]]), frozen(departures[::-1]))
