"""Safe-interval search over a roadmap: the earliest arrival among obstacles that move, waiting included.

Phillips and Likhachev 2011 (SIPP): of all times at which a node can be stood at in one stretch only the earliest
arrival counts, as waiting leads from there to the later ones. Here the stretches, and the times at which an edge may be
begun, are certified: each is a union of cells of time, and every cell is proven as a whole.

When an edge may be begun is looked for from the moment on at which that would be of use, and no farther than to the
first such time; not at all where the node that it leads to has been reached sooner.

A search looks no farther ahead than a horizon, and is made again with one twice as far where it finds nothing: what
moves later than twice the arrival costs nothing but the proof that the goal can be stayed at.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.progress import QUIET, Progress
from planner.collision.moving_prover import TimedProver
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.trajectory.limits import LEAST_JERK, USED, MotionLimits
from planner.trajectory.trajectory import NANOSECOND, Trajectory

LAW = "safe-intervals"
_State: TypeAlias = tuple[int, int]  # a node and the number of one of its stretches
_SHORTEST = 1e-6  # s: a shorter wait is none
# of the motion from rest to rest along a line that has the least jerk: 10 u^3 - 15 u^4 + 6 u^5
_QUINTIC = np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
_CELL, _FINEST = 0.5, 1 / 64  # s: cells of time are halved from the one down to the other
_FIRST = 8  # cells of the first block
_PART = 32  # cells of a block that are worked out at once: more at a time are quicker, and more than may be asked for

Proven: TypeAlias = Callable[[Floats, Floats], Bools]
"""Which of the cells of time from ``low`` (n,) to ``high`` (n,) s are proven, each as a whole."""


class TimeGrid:
    """Cells of time from 0 to ``end`` (s), from when on nothing moves, in blocks, each as long as all before it."""

    def __init__(self, end: float) -> None:
        self.corners = np.linspace(0.0, end, int(np.ceil(end / _CELL)) + 1)

    @cached_property
    def _begins(self) -> list[int]:
        """The first cell of each block; the last block is all that comes after the end."""
        begins, last = [0], len(self.corners) - 1
        while begins[-1] < last:
            begins.append(min(max(_FIRST, 2 * begins[-1]), last))
        return begins

    @cached_property
    def _times(self) -> Floats:
        """When each block begins, s."""
        return self.corners[self._begins]

    def blocks(self, low: float, high: float) -> range:
        """The numbers of the blocks that hold [low, high] s."""
        first = int(np.searchsorted(self._times, low, side="right")) - 1
        return range(first, max(first + 1, int(np.searchsorted(self._times, high, side="left"))))

    def corners_of(self, block: int) -> Floats:
        """The corners (n + 1,) of the cells of a block; of the last one, which has no cells, the end (1,)."""
        begin, after = self._begins[block], [*self._begins, len(self.corners) - 1][block + 1]
        return self.corners[begin : after + 1]

    def horizons(self, least: float) -> Iterator[float]:
        """Until when (s) whole blocks reach that hold ``least``, one block more each time; inf is the last."""
        yield from (float(time) for time in self._times[1:] if time >= least)
        yield np.inf


class CertifiedTimes:
    """When something is ``proven``, worked out block by block as it is asked for, and kept."""

    def __init__(self, proven: Proven, grid: TimeGrid) -> None:
        self._proven, self._grid = proven, grid
        self._blocks: dict[int, Floats] = {}
        self._known: dict[tuple[float, float], Floats | None] = {}
        self._joined: dict[range, Floats] = {}

    def within(self, low: float, high: float) -> Floats:
        """Stretches (k, 2) of time, ascending, which do not touch; all that are proven of the blocks of [low, high]."""
        blocks = self._grid.blocks(low, high)
        if blocks not in self._joined:
            self._joined[blocks] = _joined(np.concatenate([self._block(block) for block in blocks]))
        return self._joined[blocks]

    def first(self, low: float, high: float) -> float:
        """The first time (s) of [low, high] that is proven; inf for none. What ends before or comes after is left."""
        for block in self._grid.blocks(low, high):
            for stretches in self._parts(self._grid.corners_of(block), low):
                row = int(np.searchsorted(stretches[:, 1], low))
                if row < len(stretches):
                    found = max(low, float(stretches[row, 0]))
                    return found if found <= high else np.inf
        return np.inf

    def _block(self, block: int) -> Floats:
        if block not in self._blocks:
            self._blocks[block] = np.concatenate(list(self._parts(self._grid.corners_of(block))))
        return self._blocks[block]

    def _parts(self, corners: Floats, low: float = 0.0) -> Iterator[Floats]:
        """The stretches of a block, ascending, in parts that do not end before ``low``; as :func:`certified_cells`."""
        end = np.inf if len(corners) == 1 else float(corners[-1])
        part, middle = (float(corners[0]), end), (len(corners) - 1) // 2
        if end < low:
            return
        if part not in self._known:
            self._known[part] = self._whole(corners)
        known = self._known[part]
        if known is not None:
            yield known
        else:
            yield from self._parts(corners[: middle + 1], low)
            yield from self._parts(corners[middle:], low)

    def _whole(self, corners: Floats) -> Floats | None:
        """The stretches of a part that is short or proven at once; None for others."""
        if len(corners) == 1:
            return self._after(corners)
        if len(corners) - 1 <= _PART:
            return _joined(certified_cells(self._proven, corners))
        return corners[[0, -1]][None] if self._proven(corners[:1], corners[-1:])[0] else None

    def _after(self, end: Floats) -> Floats:
        return np.array([[end[0], np.inf]]) if self._proven(end, end)[0] else np.zeros((0, 2))

    def for_good_from(self) -> float:
        """The time (s) from which on all is proven; inf where there is none.

        Looked for from the end: what is proven as a whole is not looked into.
        """
        corners, since = self._grid.corners, np.inf
        if len(self._after(corners[-1:])):
            since, waiting = float(corners[-1]), [(0, len(corners) - 1)]
            while waiting:
                first, last = waiting.pop()
                if first == last:
                    continue
                if self._proven(corners[first : first + 1], corners[last : last + 1])[0]:
                    since = float(corners[first])
                elif last - first > 1:
                    waiting += [(first, (first + last) // 2), ((first + last) // 2, last)]
                else:
                    cells = _joined(_halves(self._proven, corners[first : first + 1], corners[last : last + 1]))
                    return float(cells[-1, 0]) if len(cells) and cells[-1, 1] == since else since
        return since


def certified_cells(proven: Proven, corners: Floats) -> Floats:
    """Cells (k, 2) from the first to the last of ``corners`` (n + 1,) that are proven, in no order.

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
    return np.concatenate([*found, _halves(proven, corners[cells], corners[cells + 1])])


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
        return Trajectory.through(prover.robot.joints, times, path[rows], rest, rest, law=LAW)


class RoadmapInTime:
    """A roadmap whose edges are run from rest to rest within limits, among what a timed prover knows.

    ``seconds`` (m,) is how long an edge takes. Stretches of time are worked out when they are asked for, and kept.
    """

    def __init__(self, roadmap: Roadmap, prover: TimedProver, limits: MotionLimits) -> None:
        self.roadmap, self.prover = roadmap, prover
        first, last = (roadmap.nodes[roadmap.edges[:, k]] for k in (0, 1))
        self.seconds = rest_to_rest(prover.robot.difference(first, last), limits.times(USED))
        self.grid = TimeGrid(prover.end)
        self._stays: dict[int, CertifiedTimes] = {}
        self._departures: dict[tuple[int, int], CertifiedTimes] = {}
        self.neighbours: list[list[tuple[int, int]]] = [[] for _ in roadmap.nodes]  # (node, edge)
        for row, (i, j) in enumerate(roadmap.edges.tolist()):
            self.neighbours[i].append((j, row))
            self.neighbours[j].append((i, row))

    def stays(self, node: int, until: float) -> Floats:
        """(k, 2) stretches of time (s), up to ``until`` or later, in which standing at a node is proven free."""
        return self._stays_at(node).within(0.0, until)

    def stays_for_good_from(self, node: int) -> float:
        """The time (s) from which on standing at a node is proven free for good; inf where it never is."""
        return self._stays_at(node).for_good_from()

    def _stays_at(self, node: int) -> CertifiedTimes:
        if node not in self._stays:
            still = np.stack([self.roadmap.nodes[node], np.zeros(self.prover.robot.dof)])

            def proven(low: Floats, high: Floats) -> Bools:
                spans = np.column_stack([low, high - low, np.zeros_like(low)])
                return self.prover.free(np.repeat(still[None], len(low), axis=0), spans)

            self._stays[node] = CertifiedTimes(proven, self.grid)
        return self._stays[node]

    def departures(self, i: int, j: int, edge: int) -> CertifiedTimes:
        """When the ``edge`` may be begun at node ``i``, each time proven free as a whole."""
        if (i, j) not in self._departures:
            a, robot = self.roadmap.nodes[i], self.prover.robot
            delta, takes = robot.difference(a, self.roadmap.nodes[j]), float(self.seconds[edge])
            motion = _QUINTIC[:, None] * delta
            motion[0] = a

            def proven(low: Floats, high: Floats) -> Bools:
                spans = np.column_stack([0.5 * (low + high), np.full_like(low, takes), 0.5 * (high - low)])
                return self.prover.free(np.repeat(motion[None], len(low), axis=0), spans)

            self._departures[i, j] = CertifiedTimes(proven, self.grid)
        return self._departures[i, j]

    def horizons(self, least: float) -> Iterator[float]:
        """How far (s) searches look ahead, one after the other, not less than ``least``; the last one for good."""
        return self.grid.horizons(least)

    def seconds_to_go(self, goals: Ints) -> Floats:
        """(n,) seconds to the nearest of ``goals`` with nothing in the way; inf where there is no path."""
        left = np.full(len(self.roadmap.nodes), np.inf)
        left[goals] = 0.0
        queue = [(0.0, int(goal)) for goal in goals]
        while queue:
            so_far, node = heapq.heappop(queue)
            if so_far > left[node]:
                continue
            for other, edge in self.neighbours[node]:
                if so_far + self.seconds[edge] < left[other]:
                    left[other] = so_far + self.seconds[edge]
                    heapq.heappush(queue, (float(left[other]), other))
        return left


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
    left = timed.seconds_to_go(frozen(sorted(good), np.int64))
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
                departure = self.timed.departures(node, other, edge).first(low, high)
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
