"""The exact trade-off: every path that some beta makes optimal on one roadmap, with the betas it is optimal for."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from planner import gabf
from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import FileError, StateError
from planner.base.outcome import Outcome
from planner.base.request import SweepRequest
from planner.collision import witness
from planner.collision.checker import CollisionChecker
from planner.costs.manipulability_floor import Course, breach, course_of
from planner.costs.network import arc_costs, build_network
from planner.paths.measure import joint_path_length, path_manipulability, tool_path_length
from planner.planning import Progress, Stopwatch, first_bad_edge, make_law, obtain_roadmap, path_waypoints
from planner.query.open import Query, make_query
from planner.roadmap.attach import SAME
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import require_same_world
from planner.tradeoff.envelope import TOLERANCE, EnvelopeSearch, Piece, pieces
from planner.tradeoff.nondominated import MAX_LABELS, Front, non_dominated, require_labels
from planner.world.robot import Robot
from planner.world.scene import Scene


@dataclass(frozen=True, eq=False)
class Interval:
    """One path and the betas [``beta_min``, ``beta_max``] that it is optimal for.

    ``path_nodes`` (k,) start first, ``path`` (k, dof) rad with continuous joints unwound. The costs are Omega and D as
    eq. (finew) sums them: at beta the path costs (1 - beta) ``manipulability_cost`` + beta ``distance_cost``.
    ``w_min`` and ``w_mean`` are sampled densely along the path, lengths are in rad and m. ``cost_to_go`` is the
    settled field at a beta of the interval (``cost_to_go.network.kernel.beta``).
    """

    beta_min: float
    beta_max: float
    path_nodes: Ints
    path: Floats
    manipulability_cost: float
    distance_cost: float
    w_min: float
    w_mean: float
    joint_length: float
    workspace_length: float
    cost_to_go: gabf.CostToGo


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """How far a sweep came, enough to go on from, and ``where`` it was read.

    ``found``: paths optimal at the beta before each, in ascending order, of which the first ``settled`` gaps are
    proven to hold no further path. ``roadmap`` is None where it was still growing.
    """

    where: Path
    roadmap: Roadmap | None = None
    found: tuple[tuple[float, Ints], ...] = ()
    settled: int = 0
    edges_removed: int = 0
    barred: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, eq=False)
class Tradeoff:
    """The trade-off with everything it was made from.

    ``intervals`` are sorted and cover [0, 1] where ``complete``; where the sweep was interrupted those that are
    proven, from 0 up; none where there is no path. ``front`` holds the non-dominated paths, where they were asked
    for. ``solves`` counts runs of the dynamics, ``max_error_vs_oracle`` is the largest relative error of all of them.
    ``found``, ``settled``, ``barred`` (legs that dip below the manipulability floor) and ``grown`` (whether the roadmap
    is whole) are what a later sweep goes on from; their nodes are those of ``course``, see
    :mod:`planner.costs.manipulability_floor`.
    """

    request: SweepRequest
    outcome: Outcome
    robot: Robot
    scene: Scene
    checker: CollisionChecker
    roadmap: Roadmap
    course: Course | None = None
    intervals: tuple[Interval, ...] = ()
    complete: bool = False
    front: Front | None = None
    grown: bool = False
    found: tuple[tuple[float, Ints], ...] = ()
    settled: int = 0
    solves: int = 0
    max_error_vs_oracle: float | None = None
    edges_removed: int = 0
    barred: tuple[tuple[int, int], ...] = ()
    timings: dict[str, float] = field(default_factory=dict)


def sweep(
    request: SweepRequest,
    progress: Progress = lambda stage, done, total: None,
    stop: Callable[[], bool] = lambda: False,
    front: bool = False,
    max_labels: int = MAX_LABELS,
    earlier: Checkpoint | None = None,
) -> Tradeoff:
    """The whole trade-off between manipulability and distance, on a roadmap that is obtained once.

    Every path is looked at again at 1 mm of motion as a plan's is; if an edge fails, the sweep starts over without it.
    With ``front`` the non-dominated paths are searched for too, with at most ``max_labels`` partial paths. ``earlier``
    is a sweep of the same request to go on from. ``progress`` hears (stage, done, total), of stage "beta" how many
    per cent of [0, 1] are settled; once ``stop`` returns True the work ends as soon as it can and what there is comes
    back with ``Outcome.INTERRUPTED``. Raises :class:`PlannerError` for unusable input.
    """
    require_labels(max_labels)
    clock = Stopwatch()
    with clock("setup"):
        query = make_query(request)
    with clock("roadmap"):
        roadmap = _obtain(request, query, progress, stop, earlier)
    robot, scene, checker = query.robot, query.scene, query.checker
    draft = Tradeoff(request, Outcome.INTERRUPTED, robot, scene, checker, roadmap, timings=clock.seconds)
    if earlier is None or earlier.roadmap is None:
        if stop():
            return draft
        earlier = Checkpoint(Path(), roadmap)
    draft = replace(
        draft,
        grown=True,
        found=earlier.found,
        settled=earlier.settled,
        edges_removed=earlier.edges_removed,
        barred=earlier.barred,
    )
    run = _Run(clock, progress, stop, _Recheck(witness(checker)), max_labels if front else 0, earlier.where)
    while True:
        try:
            return run(draft)
        except _Dips as leg:
            draft = replace(draft, found=(), settled=0, barred=(*draft.barred, (leg.i, leg.j)))
        except _EdgeFails as edge:
            roadmap = draft.roadmap
            smaller = roadmap.without_edge(roadmap.edge_index(edge.i, edge.j))
            draft = replace(
                draft, roadmap=smaller, found=(), settled=0, barred=(), edges_removed=draft.edges_removed + 1
            )


def reached_by_beta(points: Floats, intervals: Sequence[Interval]) -> Bools:
    """(k,) whether some beta makes a point (Omega, D) of ``points`` (k, 2) optimal, given the complete intervals.

    A point's cost minus the least cost is convex in beta and linear within each interval, so an end of one tells.
    """
    betas = np.array([0.0, *(interval.beta_max for interval in intervals)])
    lines = np.array([(interval.manipulability_cost, interval.distance_cost) for interval in intervals])
    shares = np.stack([1.0 - betas, betas])
    least = (lines @ shares).min(axis=0)
    return (points @ shares <= least + TOLERANCE * np.maximum(1.0, least)).any(axis=1)


def _obtain(
    request: SweepRequest, query: Query, progress: Progress, stop: Callable[[], bool], earlier: Checkpoint | None
) -> Roadmap:
    """The earlier sweep's roadmap if it is of the same query, or the one that ``request`` names."""
    if earlier is None or earlier.roadmap is None:
        return obtain_roadmap(request, query, progress, stop)
    roadmap = earlier.roadmap
    require_same_world(roadmap, query.checker, earlier.where)
    for role, wanted, nodes in (("start", query.starts, roadmap.starts), ("goal", query.goals, roadmap.goals)):
        if wanted.shape != roadmap.nodes[nodes].shape or np.abs(wanted - roadmap.nodes[nodes]).max() > SAME:
            raise FileError(f"roadmap {earlier.where} has another {role} than is asked for now: sweep anew.")
    return roadmap


class _EdgeFails(Exception):
    """An edge of a path touched something when it was looked at again."""

    def __init__(self, i: int, j: int) -> None:
        self.i, self.j = i, j


class _Dips(Exception):
    """A leg of a course, between two nodes of its network, that dips below the manipulability floor."""

    def __init__(self, i: int, j: int) -> None:
        self.i, self.j = i, j


class _Recheck:
    """Looks at paths again: at each edge once every millimetre, and at the whole path where there is a floor.

    Raises :class:`_EdgeFails` or :class:`_Dips` at what fails.
    """

    def __init__(self, checker: CollisionChecker) -> None:
        self.checker = checker
        self.seen: set[frozenset[int]] = set()

    def __call__(self, robot: Robot, roadmap: Roadmap, course: Course, floor: float, legs: Ints) -> None:
        nodes = course.place[legs]
        for pair in itertools.pairwise(nodes.tolist()):
            if frozenset(pair) in self.seen:
                continue
            if first_bad_edge(self.checker, roadmap, np.array(pair)) is not None:
                raise _EdgeFails(*pair)
            self.seen.add(frozenset(pair))
        low = breach(robot, path_waypoints(roadmap, robot, nodes), floor)
        if low is not None:
            raise _Dips(int(legs[low]), int(legs[low + 1]))


@dataclass(frozen=True, eq=False)
class _Run:
    """One sweep over one roadmap; ``max_labels`` is 0 where no front was asked for."""

    clock: Stopwatch
    progress: Progress
    stop: Callable[[], bool]
    recheck: _Recheck
    max_labels: int
    where: Path

    def __call__(self, draft: Tradeoff) -> Tradeoff:
        request, roadmap = draft.request, draft.roadmap
        with self.clock("costs"):
            network = build_network(roadmap, 0.5, request.manipulability_cost, request.metric, request.charge)
            course = course_of(roadmap, network, request.min_manipulability)
            for leg in draft.barred:
                course = course.without_leg(*leg)
        draft = replace(draft, course=course)
        search = EnvelopeSearch(course.network, course.starts, make_law(request))
        recheck = partial(self.recheck, draft.robot, roadmap, course, request.min_manipulability)
        if self._recall(search, draft, recheck):
            self._search(search, recheck)
            draft = replace(draft, found=tuple((s.beta, s.nodes) for s in search.supports), settled=search.settled)
        draft = replace(draft, solves=search.solves, max_error_vs_oracle=search.max_error if search.solves else None)
        if not search.connected:
            outcome = Outcome.TOO_SINGULAR if request.min_manipulability > 0 else Outcome.NO_PATH
            return replace(draft, outcome=outcome)
        with self.clock("measures"):
            settled = pieces(search.supports[: search.settled + 1])
            intervals = tuple(
                _interval(piece, course, roadmap, draft.robot) for piece in (settled if search.done else settled[:-1])
            )
        draft = replace(draft, intervals=intervals, complete=search.done)
        if search.done and self.max_labels:
            draft = replace(draft, front=self._front(search, course, recheck))
        cut_short = not search.done or (draft.front is not None and not draft.front.complete and self.stop())
        return draft if cut_short else replace(draft, outcome=Outcome.SOLVED)

    def _recall(self, search: EnvelopeSearch, draft: Tradeoff, recheck: Callable[[Ints], None]) -> bool:
        """Solve again what was found earlier; False where stopped before all was."""
        for beta, nodes in draft.found:
            if self.stop():
                return False
            try:
                with self.clock("gabf"):
                    search.recall(beta, nodes)
            except StateError as error:
                raise FileError(f"the sweep beside {self.where} does not fit its roadmap: {error}") from None
            with self.clock("path"):
                recheck(nodes)
        search.settled = draft.settled
        self.progress("beta", int(100 * search.reach), 100)
        return True

    def _search(self, search: EnvelopeSearch, recheck: Callable[[Ints], None]) -> None:
        while not search.done and not self.stop():
            with self.clock("gabf"):
                found = search.step()
            if found is not None:
                with self.clock("path"):
                    recheck(found.nodes)
            self.progress("beta", int(100 * search.reach), 100)

    def _front(self, search: EnvelopeSearch, course: Course, recheck: Callable[[Ints], None]) -> Front:
        """The fields of the two ends are the bounds."""
        network = search.network
        bounds = np.column_stack([search.supports[k].cost_to_go.x for k in (0, -1)])
        with self.clock("front"):
            found = non_dominated(
                network.indptr,
                network.indices,
                arc_costs(network),
                course.starts,
                network.sources,
                bounds,
                self.max_labels,
                self.progress,
                self.stop,
            )
        with self.clock("path"):
            for nodes in found.paths:
                recheck(nodes)
        return replace(found, paths=tuple(course.place[nodes] for nodes in found.paths))


def _interval(piece: Piece, course: Course, roadmap: Roadmap, robot: Robot) -> Interval:
    support, nodes = piece.support, course.place[piece.support.nodes]
    path = path_waypoints(roadmap, robot, nodes)
    w = path_manipulability(robot, path)
    return Interval(
        beta_min=piece.beta_min,
        beta_max=piece.beta_max,
        path_nodes=nodes,
        path=path,
        manipulability_cost=support.manipulability,
        distance_cost=support.distance,
        w_min=float(w.min()),
        w_mean=float(w.mean()),
        joint_length=joint_path_length(path),
        workspace_length=tool_path_length(robot, path),
        cost_to_go=support.cost_to_go,
    )
