"""Safe-interval search over a roadmap: the earliest arrival among obstacles that move, waiting included.

Phillips and Likhachev 2011 (SIPP): of all times at which a node can be stood at in one stretch only the earliest
arrival counts, as waiting leads from there to the later ones. Here the stretches, and the times at which an edge may be
begun, are certified: each is a union of cells of time, and every cell is proven as a whole.

A search looks no farther ahead than a horizon, and is made again with one twice as far where it finds nothing: what
moves later than twice the arrival costs nothing but the proof that the goal can be stayed at.
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
_State: TypeAlias = tuple[int, int]  # a node and the number of one of its stretches
_SHORTEST = 1e-6  # s: a shorter wait is none
# of the motion from rest to rest along a line that has the least jerk: 10 u^3 - 15 u^4 + 6 u^5
_QUINTIC = np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
_CELL, _FINEST = 0.5, 1 / 64  # s: cells of time are halved from the one down to the other
_FIRST = 32  # cells up to the first horizon

Proven: TypeAlias = Callable[[Floats, Floats], Bools]
"""Which of the cells of time from ``low`` (n,) to ``high`` (n,) s are proven, each as a whole."""


def certify_intervals(proven: Proven, corners: Floats) -> Floats:
    """Stretches (k, 2), ascending, which do not touch, of the time between ``corners`` (n + 1,) that are proven.

    All of it is asked for at once; what is not proven by halves, cells down to 1/64 s.
    """
    first, last = np.array([0]), np.array([len(corners) - 1])
    found, single = [np.zeros((0, 2))], []
    while len(first):
        low, high = corners[first], corners[last]
        free = proven(low, high)
        found.append(np.column_stack([low, high])[free])
        first, last = first[~free], last[~free]
        single.append(first[last - first == 1])
        first, last = first[last - first > 1], last[last - first > 1]
        middle = (first + last) // 2
        first, last = np.concatenate([first, middle]), np.concatenate([middle, last])
    cells = np.concatenate(single)
    return _joined(np.concatenate([*found, _halves(proven, corners[cells], corners[cells + 1])]))


def find_permanent_start(proven: Proven, corners: Floats) -> float:
    """The time (s) of ``corners`` (n + 1,) or between them from which on all is proven; inf where there is none.

    Looked for from the end: what is proven as a whole is not looked into.
    """
    if not proven(corners[-1:], corners[-1:])[0]:
        return np.inf
    since, waiting = float(corners[-1]), [(0, len(corners) - 1)]
    while waiting:
        first, last = waiting.pop()
        if first == last:
            continue
        if proven(corners[first : first + 1], corners[last : last + 1])[0]:
            since = float(corners[first])
        elif last - first > 1:
            waiting += [(first, (first + last) // 2), ((first + last) // 2, last)]
        else:
            cells = certify_intervals(proven, corners[first : last + 1])
            return float(cells[-1, 0]) if len(cells) and cells[-1, 1] == since else since
    return since


def _halves(proven: Proven, low: Floats, high: Floats) -> Floats:
    """Parts (k, 2) that are proven of cells from ``low`` to ``high`` (n,), which as a whole are not."""
    found = [np.zeros((0, 2))]
    while True:
        wide = high - low > _FINEST
        low, high = low[wide], high[wide]
        if not len(low):
            return np.concatenate(found)
        middle = 0.5 * (low + high)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        free = proven(low, high)
        found.append(np.column_stack([low, high])[free])
        low, high = low[~free], high[~free]


def _joined(cells: Floats) -> Floats:
    """Cells (n, 2) that meet at their ends as one."""
    cells = cells[np.argsort(cells[:, 0], kind="stable")]
    if not len(cells):
        return cells
    begins = np.concatenate([[True], cells[1:, 0] > cells[:-1, 1]])
    ends = np.concatenate([begins[1:], [True]])
    return np.column_stack([cells[begins, 0], cells[ends, 1]])


@dataclass(frozen=True, eq=False)
class TimedRoute:
    """Nodes (k,) of a roadmap, with when (s) each is reached and left; the last one is stayed at."""

    nodes: Ints
    arrivals: Floats
    departures: Floats

    @property
    def waits(self) -> Floats:
        """(k,) seconds stood at each node on the way."""
        return self.departures - self.arrivals

    def trajectory(self, roadmap: Roadmap, prover: TimedProver, limits: MotionLimits) -> Trajectory:
        """The route in time: from rest to rest along every edge, standing at nodes in between."""
        path = path_waypoints(roadmap, prover.robot, self.nodes)
        stands = self.waits > _SHORTEST
        rows = np.repeat(np.arange(len(path)), 1 + stands)
        times = np.sort(np.concatenate([self.arrivals, self.departures[stands]]))
        if len(path) == 1:
            rows, times = np.zeros(2, dtype=np.int64), np.array([0.0, _SHORTEST])
        rest = np.zeros((len(rows), path.shape[1]))
        return Trajectory.from_points(prover.robot.joints, times, path[rows], rest, rest, time_law=LAW)


class RoadmapInTime:
    """A roadmap whose edges are run from rest to rest within limits, among what a timed prover knows.

    ``seconds`` (m,) is how long an edge takes. Stretches of time are worked out when they are asked for, and kept.
    """

    def __init__(self, roadmap: Roadmap, prover: TimedProver, limits: MotionLimits) -> None:
        self.roadmap, self.prover = roadmap, prover
        first, last = (roadmap.nodes[roadmap.edges[:, k]] for k in (0, 1))
        self.seconds = rest_to_rest(prover.robot.difference(first, last), limits.scale_all(USED))
        self._corners = np.linspace(0.0, prover.end, int(np.ceil(prover.end / _CELL)) + 1)  # later nothing moves
        self._known: dict[tuple[int, int, float], Floats] = {}
        self.neighbours: list[list[tuple[int, int]]] = [[] for _ in roadmap.nodes]  # (node, edge)
        for row, (i, j) in enumerate(roadmap.edges.tolist()):
            self.neighbours[i].append((j, row))
            self.neighbours[j].append((i, row))

    def stays(self, node: int, until: float) -> Floats:
        """(k, 2) stretches of time (s), none after ``until``, in which standing at a node is proven free."""
        return self._stretches(node, -1, until)

    def departures(self, node: int, edge: int, until: float) -> Floats:
        """(k, 2) stretches of time (s), none after ``until``, in which an ``edge`` from a node is proven if begun."""
        return self._stretches(node, edge, until)

    def stays_for_good_from(self, node: int) -> float:
        """The time (s) from which on standing at a node is proven free for good; inf where it never is."""
        return find_permanent_start(self._proven(node, -1), self._corners)

    def horizons(self, least: float) -> Iterator[float]:
        """How far (s) searches look ahead, one twice as far as the one before; the last one is inf, for good."""
        count = _FIRST
        while count < len(self._corners):
            if self._corners[count] >= least:
                yield float(self._corners[count])
            count *= 2
        yield np.inf

    def _stretches(self, node: int, edge: int, until: float) -> Floats:
        if (node, edge, until) not in self._known:
            proven, end = self._proven(node, edge), self._corners[-1:]
            found = certify_intervals(proven, self._corners[self._corners <= until])
            if until > end[0] and proven(end, end)[0]:
                found = _joined(np.vstack([found, [[end[0], np.inf]]]))
            self._known[node, edge, until] = found
        return self._known[node, edge, until]

    def _proven(self, node: int, edge: int) -> Proven:
        """What tells the times at which standing at a node, or beginning an ``edge`` there, is proven free."""
        start, takes = self.roadmap.nodes[node], 0.0
        if edge < 0:
            motion = np.stack([start, 0.0 * start])
        else:
            takes = float(self.seconds[edge])
            other = int(self.roadmap.edges[edge].sum()) - node
            motion = _QUINTIC[:, None] * self.prover.robot.difference(start, self.roadmap.nodes[other])
            motion[0] = start

        def proven(low: Floats, high: Floats) -> Bools:
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
            spans = [middle, np.full_like(low, takes), half] if edge >= 0 else [low, high - low, 0.0 * low]
            return self.prover.free(np.repeat(motion[None], len(low), axis=0), np.column_stack(spans))

        return proven


def rest_to_rest(delta: Floats, limits: MotionLimits) -> Floats:
    """Seconds (n,) in which straight motions (n, dof) of least jerk keep the limits, from rest to rest.

    Whole nanoseconds, one more than it takes: when they begin and end is rounded to these.
    """
    size = np.abs(delta)
    kinds = limits.velocity, limits.acceleration, limits.jerk
    pairs = enumerate(zip(LEAST_JERK, kinds, strict=True), 1)
    shares = [(most * size / limit) ** (1 / order) for order, (most, limit) in pairs]
    return (np.ceil(np.max(shares, axis=(0, 2), initial=1e-3) / NANOSECOND) + 1.0) * NANOSECOND


def earliest_route(timed: RoadmapInTime, starts: Ints, goals: Ints, progress: Progress = QUIET) -> TimedRoute | None:
    """The route that is the first to reach one of ``goals`` and can stay there for good; None where there is none.

    It leaves one of ``starts`` at time 0 or later, and is the earliest for the certified stretches: what is free but
    too tight to be proven in cells of 1/64 s is passed over. None too where ``progress`` is asked to stop.
    """
    good: dict[int, float] = {}
    for goal in goals.tolist():
        if not progress.stopped and np.isfinite(since := timed.stays_for_good_from(goal)):
            good[goal] = since
    edges, stays = timed.roadmap.edges, frozen(sorted(good), np.int64)
    both_ways = np.concatenate([edges, edges[:, ::-1]]), np.tile(timed.seconds, 2)
    left = cheapest_costs(len(timed.neighbours), *both_ways, stays, np.zeros(len(stays)))  # s, with nothing in the way
    begun = [start for start in dict.fromkeys(starts.tolist()) if np.isfinite(left[start])]
    if not good or not begun:
        return None
    for horizon in timed.horizons(max(min(good.values()), float(left[begun].min()))):
        search = _Search(timed, good, left, horizon)
        route = search.run(begun, progress)
        if route is not None or progress.stopped or not search.cut:
            return route
    return None


@dataclass(eq=False)
class _Search:
    """A search up to a ``horizon`` (s) for goals that can be stayed at for good from ``good`` on, s by node.

    ``left`` (n,) s: to the nearest goal with nothing in the way. ``cut``: it might have found more beyond the horizon.
    """

    timed: RoadmapInTime
    good: dict[int, float]
    left: Floats
    horizon: float
    cut: bool = False
    arrival: dict[_State, float] = field(default_factory=dict)
    before: dict[_State, tuple[_State, float]] = field(default_factory=dict)

    def run(self, starts: list[int], progress: Progress) -> TimedRoute | None:
        queue: list[tuple[float, float, _State]] = []
        for start in starts:
            if len(stays := self.timed.stays(start, self.horizon)) and stays[0, 0] == 0.0:
                self.arrival[(start, 0)] = 0.0
                heapq.heappush(queue, (float(self.left[start]), 0.0, (start, 0)))
        while queue and not progress.stopped:
            _, now, state = heapq.heappop(queue)
            node, stretch = state
            if now > self.arrival[state]:
                continue
            end = float(self.timed.stays(node, self.horizon)[stretch, 1])
            if node in self.good and self.good[node] <= end:
                return _route(state, self.arrival, self.before)
            for reached, departure, at in self._moves(node, now, end):
                if at < self.arrival.get(reached, np.inf):
                    self.arrival[reached], self.before[reached] = at, (state, departure)
                    heapq.heappush(queue, (at + float(self.left[reached[0]]), at, reached))
        return None

    def _moves(self, node: int, now: float, end: float) -> Iterator[tuple[_State, float, float]]:
        """What is reached from a node at ``now`` over one edge, left by ``end``; when it is left and reached first."""
        for other, edge in self.timed.neighbours[node]:
            if np.isinf(self.left[other]):
                continue
            takes = float(self.timed.seconds[edge])
            latest = min(end, self.horizon - takes - float(self.left[other]))
            self.cut = self.cut or latest < end or end == self.horizon < np.inf
            if now > latest:
                continue
            for k, low, high in self._worth_it(other, takes, now, latest):
                open_ = self.timed.departures(node, edge, self.horizon)
                row = int(np.searchsorted(open_[:, 1], low))
                departure = max(low, float(open_[row, 0])) if row < len(open_) else np.inf
                if departure <= high:
                    yield (other, k), departure, departure + takes

    def _worth_it(self, other: int, takes: float, now: float, latest: float) -> Iterator[tuple[int, float, float]]:
        """Stretches at a node that leaving in [``now``, ``latest``] may reach sooner than known, and when to leave."""
        stays = self.timed.stays(other, self.horizon)
        low, high = np.maximum(now, stays[:, 0] - takes), np.minimum(latest, stays[:, 1] - takes)
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
