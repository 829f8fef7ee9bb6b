"""Safe-interval search over a roadmap: the earliest arrival among obstacles that move, waiting included.

Phillips and Likhachev 2011 (SIPP): of all times at which a node can be stood at in one stretch only the earliest
arrival counts, as waiting leads from there to the later ones. Here the stretches, and the times at which an edge may be
begun, are certified: each is a union of cells of time, and every cell is proven as a whole.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.progress import QUIET, Progress
from planner.collision.in_time import TimedProver
from planner.motion.limits import LEAST_JERK, USED, MotionLimits
from planner.motion.trajectory import NANOSECOND, Trajectory
from planner.roadmap.roadmap import Roadmap, path_waypoints

LAW = "safe-intervals"
_SHORTEST = 1e-6  # s: a shorter wait is none
_CELL, _FINEST = 0.5, 1 / 64  # s: cells of time are halved from the one down to the other
# of the motion from rest to rest along a line that has the least jerk: 10 u^3 - 15 u^4 + 6 u^5
_QUINTIC = np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])


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
        self._stays: dict[int, Floats] = {}
        self._departures: dict[tuple[int, int], Floats] = {}
        self.neighbours: list[list[tuple[int, int]]] = [[] for _ in roadmap.nodes]  # (node, edge)
        for row, (i, j) in enumerate(roadmap.edges.tolist()):
            self.neighbours[i].append((j, row))
            self.neighbours[j].append((i, row))

    def stays(self, node: int) -> Floats:
        """(k, 2) stretches of time (s) in which standing at a node is proven free."""
        if node not in self._stays:
            still = np.stack([self.roadmap.nodes[node], np.zeros(self.prover.robot.dof)])

            def proven(low: Floats, high: Floats) -> Bools:
                spans = np.column_stack([low, high - low, np.zeros_like(low)])
                return self.prover.free(np.repeat(still[None], len(low), axis=0), spans)

            self._stays[node] = certified_stretches(proven, self.prover.end)
        return self._stays[node]

    def stays_for_good(self, node: int) -> bool:
        """Whether standing at a node is proven free from some time on, for good."""
        stays = self.stays(node)
        return len(stays) > 0 and bool(np.isinf(stays[-1, 1]))

    def departures(self, i: int, j: int, edge: int) -> Floats:
        """(k, 2) stretches of time (s) in which the ``edge`` may be begun at node ``i``, proven free as a whole."""
        if (i, j) not in self._departures:
            a, robot = self.roadmap.nodes[i], self.prover.robot
            delta, takes = robot.difference(a, self.roadmap.nodes[j]), float(self.seconds[edge])
            motion = _QUINTIC[:, None] * delta
            motion[0] = a

            def proven(low: Floats, high: Floats) -> Bools:
                spans = np.column_stack([0.5 * (low + high), np.full_like(low, takes), 0.5 * (high - low)])
                return self.prover.free(np.repeat(motion[None], len(low), axis=0), spans)

            self._departures[i, j] = certified_stretches(proven, self.prover.end)
        return self._departures[i, j]

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


def certified_stretches(proven: Callable[[Floats, Floats], Bools], end: float) -> Floats:
    """Stretches (k, 2) of [0, inf) that are ``proven``, cell by cell; nothing moves from ``end`` (s) on.

    ``proven(low, high)`` says of cells of time (n,) which are; one that is not is halved. Stretches do not touch.
    """
    corners = np.linspace(0.0, end, int(np.ceil(end / _CELL)) + 1)
    low, high, found = corners[:-1], corners[1:], []
    while len(low):
        free = proven(low, high)
        found.append(np.column_stack([low, high])[free])
        low, high = low[~free], high[~free]
        wide = high - low > _FINEST
        low, high = low[wide], high[wide]
        middle = 0.5 * (low + high)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    last = np.array([end])
    if proven(last, last)[0]:
        found.append(np.array([[end, np.inf]]))
    return _joined(np.concatenate([np.zeros((0, 2)), *found]))


def _joined(cells: Floats) -> Floats:
    """Cells (n, 2) that meet at their ends as one."""
    cells = cells[np.argsort(cells[:, 0], kind="stable")]
    if not len(cells):
        return cells
    begins = np.concatenate([[True], cells[1:, 0] > cells[:-1, 1]])
    ends = np.concatenate([begins[1:], [True]])
    return np.column_stack([cells[begins, 0], cells[ends, 1]])


@dataclass(frozen=True, order=True)
class _State:
    """A node in one of its stretches."""

    node: int
    stretch: int


def earliest_route(timed: RoadmapInTime, starts: Ints, goals: Ints, progress: Progress = QUIET) -> TimedRoute | None:
    """The route that is the first to reach one of ``goals`` and can stay there for good; None where there is none.

    It leaves one of ``starts`` at time 0 or later, and is the earliest for the certified stretches: what is free but
    too tight to be proven in cells of 1/64 s is passed over. None too where ``progress`` is asked to stop.
    """
    wanted = {goal for goal in goals.tolist() if timed.stays_for_good(goal)}
    left = timed.seconds_to_go(frozen(sorted(wanted), np.int64))
    arrival: dict[_State, float] = {}
    before: dict[_State, tuple[_State, float]] = {}
    queue: list[tuple[float, float, _State]] = []
    for start in dict.fromkeys(starts.tolist()):
        if np.isfinite(left[start]) and len(stays := timed.stays(start)) and stays[0, 0] == 0.0:
            arrival[_State(start, 0)] = 0.0
            heapq.heappush(queue, (float(left[start]), 0.0, _State(start, 0)))
    while queue and not progress.stopped:
        _, now, state = heapq.heappop(queue)
        if now > arrival[state]:
            continue
        end = timed.stays(state.node)[state.stretch, 1]
        if state.node in wanted and np.isinf(end):
            return _route(state, arrival, before)
        for reached, departure, at in _moves(timed, state, now, end):
            if at < arrival.get(reached, np.inf):
                arrival[reached], before[reached] = at, (state, departure)
                heapq.heappush(queue, (at + float(left[reached.node]), at, reached))
    return None


def _moves(timed: RoadmapInTime, state: _State, now: float, end: float) -> list[tuple[_State, float, float]]:
    """What is reached from a state at ``now`` over one edge, left by ``end``; departure and arrival, the earliest."""
    found = []
    for other, edge in timed.neighbours[state.node]:
        takes = float(timed.seconds[edge])
        windows, stays = timed.departures(state.node, other, edge), timed.stays(other)
        for (opens, closes), (k, (begins, ends)) in itertools.product(windows.tolist(), enumerate(stays.tolist())):
            departure = max(now, opens, begins - takes)
            if departure <= min(end, closes, ends - takes):
                found.append((_State(other, k), departure, departure + takes))
    return found


def _route(last: _State, arrival: dict[_State, float], before: dict[_State, tuple[_State, float]]) -> TimedRoute:
    states, departures = [last], [arrival[last]]
    while states[-1] in before:
        state, departure = before[states[-1]]
        states.append(state)
        departures.append(departure)
    states.reverse()
    departures.reverse()
    nodes = frozen([state.node for state in states], np.int64)
    return TimedRoute(nodes, frozen([arrival[state] for state in states]), frozen(departures))
