"""A ladder: inverse kinematics solutions at stations of a tool path, and proven motions between them.

Solutions are spread over branches, redundancy and free turns at a few stations, and each is continued from station to
station by the nearest solution, over the whole path: a thread. A motion between neighbours on a thread, or to near
solutions of other threads, becomes an arc if it is proven to stay in the tube; an unproven motion on a thread is halved
at a solution for its middle. So no joint changes by more than the tube explains.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, distinct_rows
from planner.constraints.tool_bound import Frame, ToolBound
from planner.kinematics.inverse import solve_each
from planner.kinematics.manipulability import manipulability
from planner.robot.robot import Robot
from planner.tool_paths.tool_path import align_z, rotate_about
from planner.tool_paths.tube import Tube

_ANCHORS = 5  # stations with a search from random seeds
_STARTS = 64  # descents per anchor
_THREADS = 6  # solutions per anchor that are continued
_NEAR = 3  # motions from each solution to other threads
_STEP = 0.4  # of the square root of the tube (m) between stations; twice the step needs four times the tube
_HALVINGS = 5
_SAME = 1e-4  # rad (m): closer solutions are the same
_FAR = 0.5  # rad (m): a larger step of a thread is a jump to another branch
_HOPELESS = 64.0  # times the tube: motions between threads with a larger bound are not proven


@dataclass(frozen=True, eq=False)
class Ladder:
    """Rungs ``q`` (n, dof) at ``share`` (n,) of line ``line`` (n,) of the path, and arcs (m, 2) forward.

    ``along`` (n,) and ``stations`` (s,) are m from the path's start; every arc's straight joint motion is proven to
    stay in the tube.
    """

    robot: Robot
    tube: Tube
    q: Floats
    line: Ints
    share: Floats
    arcs: Ints
    stations: Floats

    @property
    def along(self) -> Floats:
        return self.tube.path.along[self.line] + self.share * self.tube.path.lengths[self.line]


def build_ladder(
    robot: Robot,
    tube: Tube,
    step: float | None = None,
    seed: int = 0,
    dense: int = 1,
    is_allowed: Callable[[Floats], Bools] | None = None,
) -> Ladder:
    """Return the ladder of a path for ``robot``, with stations at most ``step`` (m) apart.

    A larger ``dense`` multiplies the number of solutions. Threads start at solutions (k, dof) for which ``is_allowed``
    is true (k,), if there are any. The result depends on the arguments alone: no search ends by time.
    """
    stations = _Stations.along(tube, step or np.inf)
    return _link_threads(
        robot, tube, stations, _build_threads(robot, stations, np.random.default_rng(seed), dense, is_allowed)
    )


def continue_ladder(robot: Robot, tube: Tube, q: Floats) -> Ladder:
    """Return the ladder of one thread, from the solution ``q`` (dof,) at the start of a path."""
    stations = _Stations.along(tube)
    threads = np.full((1, len(stations.line), robot.dof), np.nan)
    threads[0, 0] = q
    for k in range(len(stations.line) - 1):
        _continue_threads(robot, stations, threads, np.eye(3)[None], k, k + 1)
    return _link_threads(robot, tube, stations, threads)


@dataclass(frozen=True, eq=False)
class _Stations:
    """Targets (s, 4, 4) at points of a path, whether the tool turns freely there (s,), and cones (s,).

    Solutions may be off their targets by ``tolerances`` (s, 2), m and rad.
    """

    line: Ints
    share: Floats
    targets: Floats
    free: Bools
    cones: Floats
    tolerances: Floats

    def select(self, rows: Ints) -> _Stations:
        return _Stations(*(getattr(self, each.name)[rows] for each in fields(self)))

    @staticmethod
    def along(tube: Tube, step: float = np.inf) -> _Stations:
        """Return stations along the whole path, at most ``step`` (m) apart."""
        step = min(step, _STEP * float(np.sqrt(tube.path.tube.position)))
        return _Stations.at_shares(tube, *tube.path.divide(tube.path.lengths / step))

    @staticmethod
    def at_shares(tube: Tube, line: Ints, share: Floats) -> _Stations:
        """Return stations at shares (n,) of the lines (n,) of the path."""
        path = tube.path
        position, turn, free, cone = path.at(line, share)
        targets = np.tile(np.eye(4), (len(line), 1, 1))
        targets[:, :3, 3], targets[:, :3, :3] = position, turn
        cone[free] = np.maximum(cone[free], tube.lean)
        return _Stations(line, share, targets, free, cone, tube.tolerances(free))


def solutions_at(
    robot: Robot, tube: Tube, along: float, starts: int, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Return :func:`_solve` for ``starts`` descents with random turns, ``along`` m of the path."""
    path = tube.path
    line = np.clip(np.searchsorted(path.along, along - 1e-9) - 1, 0, len(path.lengths) - 1)
    share = np.clip((along - path.along[line]) / path.lengths[line], 0.0, 1.0)
    stations = _Stations.at_shares(tube, np.full(starts, line), np.full(starts, share))
    z = (stations.targets[:, :3, :3] @ _draw_tilts(stations.cones, rng))[:, :, 2]
    return _solve(robot, stations, z, rng.uniform(robot.lower, robot.upper, size=(starts, robot.dof)))


def _solve(robot: Robot, stations: _Stations, z: Floats, seeds: Floats) -> tuple[Floats, Floats]:
    """Return configurations (n, dof), nan without a solution, and their errors (n, 2) m and rad.

    One per station, from ``seeds`` (n, dof). Where the tool turns freely, its z axis is along ``z`` (n, 3), and its
    turn is as near to the seed's as possible.
    """
    q, off = np.empty_like(seeds), np.empty((len(seeds), 2))
    for free in (False, True):
        rows = np.flatnonzero(stations.free == free)
        targets = stations.targets[rows]
        if free and len(rows):
            targets[:, :3, :3] = align_z(z[rows], Frame.tool(robot).poses(robot, seeds[rows])[0])
        q[rows], *missed = solve_each(robot, targets, seeds[rows], free)
        off[rows] = np.stack(missed, axis=1)
    q[(off > stations.tolerances).any(axis=1)] = np.nan
    return q, off


def _build_threads(
    robot: Robot,
    stations: _Stations,
    rng: np.random.Generator,
    dense: int,
    is_allowed: Callable[[Floats], Bools] | None,
) -> Floats:
    """Return the solutions (t, s, dof) of every thread, nan beyond its ends."""
    s = len(stations.line)
    anchors = np.unique(np.linspace(0, s - 1, min(_ANCHORS * dense, s)).round().astype(np.int64))
    bound = np.flatnonzero(~stations.free)
    if 0 < len(bound) < s:  # only threads that start there have their orientation
        anchors = np.unique(np.append(anchors, bound[np.abs(bound[:, None] - anchors).argmin(axis=0)]))
    at = np.repeat(anchors, _STARTS * dense)
    tilts, there = _draw_tilts(stations.cones[at], rng), stations.select(at)
    z = (there.targets[:, :3, :3] @ tilts)[:, :, 2]
    q, _ = _solve(robot, there, z, rng.uniform(robot.lower, robot.upper, size=(len(at), robot.dof)))
    good = np.isfinite(q[:, 0])
    if is_allowed is not None and good.any():
        good[good] = is_allowed(q[good])
    rows_of_anchor = np.split(np.arange(len(at)), len(anchors))
    chosen = np.concatenate([_choose_apart(robot, q, good, rows, _THREADS) for rows in rows_of_anchor])
    threads = np.full((len(chosen), s, robot.dof), np.nan)
    threads[np.arange(len(chosen)), at[chosen]] = q[chosen]
    for step, order in ((1, range(s - 1)), (-1, range(s - 1, 0, -1))):
        for k in order:
            _continue_threads(robot, stations, threads, tilts[chosen], k, k + step)
    return threads


def _draw_tilts(cones: Floats, rng: np.random.Generator) -> Floats:
    """Return random rotations (n, 3, 3) that tilt the z axis of a target within its cone, uniformly."""
    n = len(cones)
    side, lean = rng.uniform(-np.pi, np.pi, n), 0.9 * cones * np.sqrt(rng.uniform(size=n))
    return rotate_about(np.stack([np.cos(side), np.sin(side), np.zeros(n)], axis=1), lean)


def _choose_apart(robot: Robot, q: Floats, good: Bools, rows: Ints, count: int) -> Ints:
    """Return up to ``count`` of the ``rows``: the best by w, then always the farthest from the others.

    They are ``good`` (n,) if there are such, else any solutions.
    """
    rows = rows[good[rows]] if good[rows].any() else rows[np.isfinite(q[rows, 0])]
    if not len(rows):
        return rows
    chosen = [int(manipulability(robot, q[rows]).argmax())]
    away = np.full(len(rows), np.inf)
    while len(chosen) < count:
        away = np.minimum(away, np.abs(robot.difference(q[rows[chosen[-1]]], q[rows])).max(axis=1))
        if away.max() <= _SAME:
            break
        chosen.append(int(away.argmax()))
    return rows[chosen]


def _continue_threads(robot: Robot, stations: _Stations, threads: Floats, tilts: Floats, here: int, there: int) -> None:
    """Continue threads that end at station ``here`` to station ``there``, by the nearest solutions."""
    rows = np.flatnonzero(np.isfinite(threads[:, here, 0]) & ~np.isfinite(threads[:, there, 0]))
    if not len(rows):
        return
    seeds, target = threads[rows, here], stations.select(np.full(len(rows), there))
    leaning = tilts[rows] if stations.cones[there] > 0 else np.eye(3)
    q, _ = _solve(robot, target, (target.targets[:, :3, :3] @ leaning)[:, :, 2], seeds)
    far = ~(np.abs(robot.difference(seeds, q)).max(axis=1) <= _FAR)
    q[far] = np.nan
    threads[rows, there] = q


def _link_threads(robot: Robot, tube: Tube, stations: _Stations, threads: Floats) -> Ladder:
    """Return the ladder of threads: proven arcs along each, and to near solutions of others."""
    s = len(stations.line)
    nodes, number = _number_solutions(robot, threads)
    station = np.concatenate([np.full(len(rows), k) for k, rows in enumerate(nodes)])
    q = np.concatenate(nodes)
    along = tube.path.along[stations.line] + stations.share * tube.path.lengths[stations.line]
    none = np.zeros((0, 2), dtype=np.int64)
    ladder = Ladder(robot, tube, q, stations.line[station], stations.share[station], none, along)
    alive = (number[:, :-1] >= 0) & (number[:, 1:] >= 0)
    own = np.unique(np.stack([number[:, :-1][alive], number[:, 1:][alive]], axis=1), axis=0)
    first = np.searchsorted(station, np.arange(s + 1))
    return _add_proven_arcs(ladder, own, _find_near_arcs(robot, q, first, own))


def _number_solutions(robot: Robot, threads: Floats) -> tuple[list[Floats], Ints]:
    """Return the distinct solutions (k, dof) per station, and each thread's number (t, s), -1 for none."""
    t, s, _ = threads.shape
    number, nodes, count = np.full((t, s), -1, dtype=np.int64), [], 0
    for k in range(s):
        rows = np.flatnonzero(np.isfinite(threads[:, k, 0]))
        q = robot.normalise(threads[rows, k])
        first, which = distinct_rows(np.round(q / _SAME))
        number[rows, k] = count + which
        nodes.append(q[first])
        count += len(first)
    return nodes, number


def _find_near_arcs(robot: Robot, q: Floats, first: Ints, own: Ints) -> Ints:
    """Return motions (m, 2) from each solution to the nearest ones of other threads at the next station."""
    blocks = []
    for low, middle, high in zip(first, first[1:], first[2:], strict=False):
        if middle == low or high == middle:
            continue
        away = np.linalg.norm(robot.difference(q[low:middle, None], q[None, middle:high]), axis=2)
        order = np.argsort(away, axis=1, kind="stable")[:, : _NEAR + 1]
        blocks.append(np.stack([np.repeat(np.arange(low, middle), order.shape[1]), middle + order.ravel()], axis=1))
    near = np.concatenate([*blocks, np.zeros((0, 2), dtype=np.int64)])
    n = len(q)
    return near[~np.isin(near[:, 0] * n + near[:, 1], own[:, 0] * n + own[:, 1])]


def _add_proven_arcs(ladder: Ladder, own: Ints, near: Ints) -> Ladder:
    """Return the ladder with the arcs that are proven in the tube; those of threads are halved if needed."""
    bound = ToolBound(ladder.robot)
    near = near[_are_promising(ladder, bound, near)]
    arcs = [near[_are_in_tube(ladder, bound, near)]]
    for _ in range(_HALVINGS):
        own = own[np.isfinite(ladder.q[own]).all(axis=(1, 2))]
        good = _are_in_tube(ladder, bound, own)
        arcs.append(own[good])
        own = own[~good]
        if not len(own):
            break
        ladder, own = _halve(ladder, own)
    proven = np.concatenate(arcs)
    used = np.zeros(len(ladder.q), dtype=bool)
    used[proven] = True
    order = np.flatnonzero(used)[np.argsort(ladder.along[used], kind="stable")]
    number = np.full(len(ladder.q), -1)
    number[order] = np.arange(len(order))
    parts = {name: getattr(ladder, name)[order] for name in ("q", "line", "share")}
    return replace(ladder, arcs=number[proven], **parts)


def _motions(ladder: Ladder, arcs: Ints) -> Floats:
    """Return the coefficients (m, 2, dof) of straight motions."""
    a = ladder.q[arcs[:, 0]]
    return np.stack([a, ladder.robot.difference(a, ladder.q[arcs[:, 1]])], axis=1)


def _are_promising(ladder: Ladder, bound: ToolBound, arcs: Ints) -> Bools:
    """Return which motions (m,) have a bound near enough to the tube for a proof to be worth its time."""
    off, turned = bound(_motions(ladder, arcs)) if len(arcs) else (np.zeros(0), np.zeros(0))
    tube = ladder.tube.path.tube
    return (off <= _HOPELESS * tube.position) & (turned <= _HOPELESS * tube.angle)


def _are_in_tube(ladder: Ladder, bound: ToolBound, arcs: Ints) -> Bools:
    """Return which motions (m,) between neighbours are proven to stay in the tube."""
    if not len(arcs):
        return np.zeros(0, dtype=bool)
    line = np.where(ladder.share[arcs[:, 0]] < 1.0, ladder.line[arcs[:, 0]], ladder.line[arcs[:, 1]])
    return ladder.tube.prove(bound, _motions(ladder, arcs), line[:, None])


def _halve(ladder: Ladder, arcs: Ints) -> tuple[Ladder, Ints]:
    """Return the ladder with a solution for the middle of each of ``arcs`` (m, 2), if any, and the halves."""
    robot, (a, b) = ladder.robot, arcs.T
    line, share = (
        ladder.line[a],
        0.5 * (ladder.share[a] + np.where(ladder.line[b] > ladder.line[a], 1.0, ladder.share[b])),
    )
    stations = _Stations.at_shares(ladder.tube, line, share)
    motions = _motions(ladder, arcs)
    seeds = motions[:, 0] + 0.5 * motions[:, 1]
    z = stations.targets[:, :3, 2]
    leaning = stations.cones > 0
    z[leaning] = Frame.tool(robot).poses(robot, seeds[leaning])[0][:, :, 2]
    q, _ = _solve(robot, stations, z, seeds)
    size = np.abs(motions[:, 1]).max(axis=1)
    q[~(np.abs(robot.difference(seeds, q)).max(axis=1) <= size)] = np.nan
    new = len(ladder.q) + np.arange(len(q))
    more = {"q": np.concatenate([ladder.q, robot.normalise(q)]), "line": np.append(ladder.line, line),
            "share": np.append(ladder.share, share)}  # fmt: skip
    halves = np.concatenate([np.stack([a, new], axis=1), np.stack([new, b], axis=1)])
    return replace(ladder, **more), halves
