"""The exact trade-off: every path that some beta makes optimal on one roadmap, with the betas it is optimal for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from planner import gabf
from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.errors import FileError, StateError
from planner.base.places import Place, place
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.collision.checker import CollisionChecker
from planner.construction.connect_endpoints import SAME
from planner.construction.obtain import obtain_roadmap
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.paths.measure import measure_path
from planner.planning.healing import HealingNetwork
from planner.planning.improvement import improved_roadmap, roomy_roadmap
from planner.planning.manipulability_floor import LayeredNetwork
from planner.planning.network import arc_costs, build_network
from planner.problem.outcome import Outcome
from planner.problem.request import SweepRequest
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import require_same_world
from planner.setup.open import Query, make_query
from planner.tradeoff.envelope import TOLERANCE, EnvelopeSearch, Piece, pieces
from planner.tradeoff.nondominated import MAX_LABELS, Front, non_dominated, require_labels

IMPROVED_AT = (0.0, 0.25, 0.5, 0.75, 1.0)  # betas at which the roadmap is improved before the sweep


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

    @property
    def betas(self) -> str:
        """The interval with as many digits as tell its ends apart: "0.238 to 0.479", "0.99979 to 1"."""
        return range_text(self.beta_min, self.beta_max)


def range_text(low: float, high: float, between: str = " to ") -> str:
    """Two numbers in [0, 1] with three digits behind the point, or as many as tell them apart."""
    apart = high - low
    digits = min(12, max(3, 1 - int(np.floor(np.log10(apart))))) if apart > 0.0 else 3
    return between.join(f"{value:.{digits}f}".rstrip("0").rstrip(".") for value in (low, high))


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
    ``found``, ``settled``, ``barred`` (arcs that fall below the manipulability floor) and ``grown`` (whether the
    roadmap is whole) are what a later sweep goes on from; their nodes are those of ``layered``, see
    :mod:`planner.planning.manipulability_floor`.
    """

    request: SweepRequest
    outcome: Outcome
    robot: Robot
    scene: Scene
    checker: CollisionChecker
    roadmap: Roadmap
    layered: LayeredNetwork | None = None
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
    clearance: float = 0.0  # m beyond the margin that every path keeps
    timings: dict[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        count = f"{len(self.intervals)} intervals of beta"
        return f"<Tradeoff: {self.robot.name} in {self.scene.name}, {self.outcome.key}, {count}>"

    def _repr_html_(self) -> str:
        from planner.tradeoff.record import sweep_table

        return sweep_table(self)

    def page(self) -> str:
        """The page as HTML text that needs nothing but a browser."""
        from planner.tradeoff.page import sweep_page

        return sweep_page(self)

    def save(self, folder: Place) -> None:
        """Write ``sweep.json``, ``sweep.csv``, ``sweep.html`` and ``roadmap.npz`` under ``folder``."""
        from planner.tradeoff.record import save_sweep

        save_sweep(self, place(folder, "folder"))


def sweep(
    request: SweepRequest,
    progress: Progress = QUIET,
    front: bool = False,
    max_labels: int = MAX_LABELS,
    earlier: Checkpoint | None = None,
) -> Tradeoff:
    """The whole trade-off between manipulability and distance, on a roadmap that is obtained once.

    Every path is checked again at every 1 mm of motion, as a plan's is; what fails is removed and the sweep restarts.
    With ``front`` the non-dominated paths are searched for too, with at most ``max_labels`` partial paths. ``earlier``
    is a sweep of the same request to go on from. ``progress`` is called with (stage, done, total), for stage "beta"
    with the per cent of [0, 1] that are settled; once it is asked to stop the work ends as soon as it can, and what
    there is comes back with ``Outcome.INTERRUPTED``. Raises :class:`PlannerError` for unusable input.
    """
    require_labels(max_labels)
    clock = Stopwatch()
    with clock("setup"):
        query = make_query(request)
    with clock("roadmap"):
        roadmap = _obtain(request, query, progress, earlier)
    robot, scene, checker = query.robot, query.scene, query.checker
    draft = Tradeoff(request, Outcome.INTERRUPTED, robot, scene, checker, roadmap, timings=clock.seconds)
    if earlier is None or earlier.roadmap is None:
        if progress.stopped:
            return draft
        earlier = Checkpoint(Path(), roadmap)
    kept = {name: getattr(earlier, name) for name in ("found", "settled", "edges_removed", "barred")}
    draft = replace(draft, grown=True, **kept)
    run = _Run(clock, progress, max_labels if front else 0, earlier.where)
    with clock("costs"):
        roadmap, clearance = _roomy(request, query, roadmap, progress)
        network = build_network(roadmap, request.objective_at(0.5), clearance)
        draft = replace(draft, roadmap=roadmap, clearance=clearance)
        healing = HealingNetwork(checker, roadmap, network, request.min_manipulability, earlier.barred)
    while True:
        try:
            return run(draft, healing)
        except _Healed:
            removed = earlier.edges_removed + healing.edges_removed
            anew = {"found": (), "settled": 0, "barred": healing.barred, "edges_removed": removed}
            draft = replace(draft, roadmap=healing.roadmap, **anew)


def reached_by_beta(points: Floats, intervals: Sequence[Interval]) -> Bools:
    """(k,) whether some beta makes a point (Omega, D) of ``points`` (k, 2) optimal, given the complete intervals.

    A point's cost minus the least cost is convex in beta and linear within each interval, so an end of one tells.
    """
    betas = np.array([0.0, *(interval.beta_max for interval in intervals)])
    lines = np.array([(interval.manipulability_cost, interval.distance_cost) for interval in intervals])
    shares = np.stack([1.0 - betas, betas])
    least = (lines @ shares).min(axis=0)
    return (points @ shares <= least + TOLERANCE * np.maximum(1.0, least)).any(axis=1)


def _obtain(request: SweepRequest, query: Query, progress: Progress, earlier: Checkpoint | None) -> Roadmap:
    """The earlier sweep's roadmap if it is of the same query, or the one that ``request`` names, improved."""
    if earlier is None or earlier.roadmap is None:
        roadmap = obtain_roadmap(request, query, progress)
        roadmap, clearance = _roomy(request, query, roadmap, progress)
        for beta in IMPROVED_AT:
            roadmap = improved_roadmap(roadmap, query.checker, request, beta, progress, clearance).roadmap
        return roadmap
    roadmap = earlier.roadmap
    require_same_world(roadmap, query.checker, earlier.where)
    for role, wanted, nodes in (("start", query.starts, roadmap.starts), ("goal", query.goals, roadmap.goals)):
        found = roadmap.nodes[nodes]
        if wanted.shape != found.shape or np.abs(query.robot.difference(wanted, found)).max() > SAME:
            raise FileError(f"roadmap {earlier.where} has another {role} than is asked for now: sweep anew.")
    return roadmap


def _roomy(request: SweepRequest, query: Query, roadmap: Roadmap, progress: Progress) -> tuple[Roadmap, float]:
    """As :func:`planner.planning.improvement.roomy_roadmap`; a kept roadmap that is not refined stays as it is."""
    if request.rounds < 1:
        return roadmap, 0.0
    return roomy_roadmap(roadmap, query.checker, request, progress)


class _Healed(Exception):
    """A path failed its second check, and the network was healed: all begins anew."""


@dataclass(frozen=True, eq=False)
class _Run:
    """One sweep over one network; ``max_labels`` is 0 where no front was asked for."""

    clock: Stopwatch
    progress: Progress
    max_labels: int
    where: Path

    def __call__(self, draft: Tradeoff, healing: HealingNetwork) -> Tradeoff:
        """The trade-off as far as it comes; :class:`_Healed` where a path failed its second check."""
        request, layered = draft.request, healing.layered
        law = gabf.named_law(request.law, request.prescribed_time)
        search = EnvelopeSearch(layered.network, layered.starts, law)
        found, settled = draft.found, draft.settled
        if self._recall(search, draft, healing):
            while not search.done and not self.progress.stopped:
                with self.clock("gabf"):
                    support = search.step()
                if support is not None:
                    self._require_accepted(healing, support.nodes)
                self.progress("beta", int(100 * search.reach), 100)
            found, settled = tuple((s.beta, frozen(s.nodes, np.int64)) for s in search.supports), search.settled
        error = search.max_error if search.solves else None
        draft = replace(
            draft, layered=layered, found=found, settled=settled, solves=search.solves, max_error_vs_oracle=error
        )
        if not search.connected:
            outcome = Outcome.TOO_SINGULAR if request.min_manipulability > 0 else Outcome.NO_PATH
            return replace(draft, outcome=outcome)
        with self.clock("measures"):
            known = pieces(search.supports[: search.settled + 1])
            intervals = tuple(_interval(piece, healing) for piece in (known if search.done else known[:-1]))
        front = self._front(search, healing) if search.done and self.max_labels else None
        draft = replace(draft, intervals=intervals, complete=search.done, front=front)
        cut_short = not search.done or (front is not None and not front.complete and self.progress.stopped)
        return draft if cut_short else replace(draft, outcome=Outcome.SOLVED)

    def _recall(self, search: EnvelopeSearch, draft: Tradeoff, healing: HealingNetwork) -> bool:
        """Solve again what was found earlier; False where stopped before all was."""
        for beta, nodes in draft.found:
            if self.progress.stopped:
                return False
            try:
                with self.clock("gabf"):
                    search.recall(beta, nodes)
            except StateError as error:
                raise FileError(f"the sweep beside {self.where} does not fit its roadmap: {error}") from None
            self._require_accepted(healing, nodes)
        try:
            search.recall_settled(draft.settled)
        except StateError as error:
            raise FileError(f"the sweep beside {self.where} does not fit its roadmap: {error}") from None
        self.progress("beta", int(100 * search.reach), 100)
        return True

    def _front(self, search: EnvelopeSearch, healing: HealingNetwork) -> Front:
        """The non-dominated paths, the fields of the two ends being the bounds."""
        network, layered = search.network, healing.layered
        bounds = np.column_stack([search.supports[k].x for k in (0, -1)])
        arcs, ends = (network.indptr, network.indices, arc_costs(network)), (layered.starts, network.sources)
        with self.clock("front"):
            found = non_dominated(*arcs, *ends, bounds, self.max_labels, self.progress)
        for nodes in found.paths:
            self._require_accepted(healing, nodes)
        return replace(found, paths=tuple(layered.roadmap_node[nodes] for nodes in found.paths))

    def _require_accepted(self, healing: HealingNetwork, nodes: Ints) -> None:
        with self.clock("path"):
            if not healing.accepts(nodes):
                raise _Healed


def _interval(piece: Piece, healing: HealingNetwork) -> Interval:
    support, path = piece.support, healing.waypoints(piece.support.nodes)
    assert support.cost_to_go is not None  # a sweep runs the dynamics
    return Interval(
        beta_min=piece.beta_min,
        beta_max=piece.beta_max,
        path_nodes=frozen(healing.layered.roadmap_node[support.nodes], np.int64),
        path=path,
        manipulability_cost=support.manipulability,
        distance_cost=support.distance,
        cost_to_go=support.cost_to_go,
        **asdict(measure_path(healing.robot, path)),
    )
