"""The exact trade-off: every path that some beta makes optimal on one roadmap, with the betas it is optimal for."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints, frozen
from planner.base.files import StrPath
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.collision.checker import CollisionChecker
from planner.planning.improvement import improved_roadmap, roomy_roadmap
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, SweepQuality, SweepRequest
from planner.query.query import Query, make_query
from planner.roadmap.obtain import obtain_roadmap
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.search.healing import HealingNetwork
from planner.search.manipulability_floor import LayeredNetwork
from planner.search.network import build_network
from planner.tradeoff.envelope import EnvelopeSearch, Piece, pieces
from planner.trajectory.measure import measure_path

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
class Tradeoff:
    """The trade-off with everything it was made from.

    ``intervals`` are sorted and cover [0, 1] where ``complete``; where the sweep was interrupted those that are
    proven, from 0 up; none where there is no path. ``solves`` counts runs of the dynamics, ``max_error_vs_oracle`` is
    the largest relative error of all of them.
    """

    request: SweepRequest | PlanRequest
    outcome: Outcome
    robot: Robot
    scene: Scene
    checker: CollisionChecker
    roadmap: Roadmap
    layered: LayeredNetwork | None = None
    intervals: tuple[Interval, ...] = ()
    complete: bool = False
    solves: int = 0
    max_error_vs_oracle: float | None = None
    edges_removed: int = 0
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

    def save(self, folder: StrPath) -> None:
        """Write ``sweep.json``, ``sweep.csv``, ``sweep.html`` and ``roadmap.npz`` under ``folder``."""
        from planner.tradeoff.record import save_sweep

        save_sweep(self, Path(folder))


def sweep(request: SweepRequest | PlanRequest, progress: Progress = QUIET) -> Tradeoff:
    """The whole trade-off between manipulability and distance, on a roadmap that is obtained once.

    Every path is checked again at every 1 mm of motion, as a plan's is; a path that fails is removed and the sweep
    restarts. ``progress`` is called with (stage, done, total), for stage "beta" with the per cent of [0, 1] that are
    settled; once it is asked to stop the sweep ends soon after and returns the intervals that are proven, with
    ``Outcome.INTERRUPTED``. Raises :class:`PlannerError` for unusable input.
    """
    clock = Stopwatch()
    with clock("setup"):
        query = make_query(request.what)
    with clock("roadmap"):
        roadmap = _obtain(request.quality, query, progress)
    robot, scene, checker = query.robot, query.scene, query.checker
    draft = Tradeoff(request, Outcome.INTERRUPTED, robot, scene, checker, roadmap, timings=clock.seconds)
    if progress.stopped:
        return draft
    with clock("costs"):
        roadmap, clearance = _roomy(request.quality, query, roadmap, progress)
        network = build_network(roadmap, request.quality.objective_at(0.5), clearance)
        healing = HealingNetwork(checker, roadmap, network, request.quality.min_manipulability)
    draft = replace(draft, roadmap=roadmap, clearance=clearance)
    while (done := _sweep_once(draft, healing, clock, progress)) is None:
        draft = replace(draft, roadmap=healing.roadmap, edges_removed=healing.edges_removed)
    return done


def _sweep_once(draft: Tradeoff, healing: HealingNetwork, clock: Stopwatch, progress: Progress) -> Tradeoff | None:
    """The trade-off as far as it comes; None where a path failed its second check, and the network was healed."""
    request, layered = draft.request, healing.layered
    law = gabf.named_law(request.quality.law, request.quality.prescribed_time)
    search = EnvelopeSearch(layered.network, layered.starts, law)
    while not search.done and not progress.stopped:
        with clock("gabf"):
            support = search.step()
        if support is not None:
            with clock("path"):
                accepted = healing.accepts(support.nodes)
            if not accepted:
                return None
        progress("beta", int(100 * search.reach), 100)
    error = search.max_error if search.solves else None
    draft = replace(draft, layered=layered, solves=search.solves, max_error_vs_oracle=error)
    if not search.connected:
        outcome = Outcome.TOO_SINGULAR if request.quality.min_manipulability > 0 else Outcome.NO_PATH
        return replace(draft, outcome=outcome)
    with clock("measures"):
        known = pieces(search.supports[: search.settled + 1])
        intervals = tuple(_interval(piece, healing) for piece in (known if search.done else known[:-1]))
    outcome = Outcome.SOLVED if search.done else Outcome.INTERRUPTED
    return replace(draft, intervals=intervals, complete=search.done, outcome=outcome)


def _obtain(quality: SweepQuality, query: Query, progress: Progress) -> Roadmap:
    """The roadmap that ``quality`` names or grows, improved at several betas."""
    roadmap = obtain_roadmap(quality, query, progress)
    roadmap, clearance = _roomy(quality, query, roadmap, progress)
    for beta in IMPROVED_AT:
        roadmap = improved_roadmap(roadmap, query.checker, quality, beta, progress, clearance).roadmap
    return roadmap


def _roomy(quality: SweepQuality, query: Query, roadmap: Roadmap, progress: Progress) -> tuple[Roadmap, float]:
    """As :func:`planner.planning.improvement.roomy_roadmap`; a kept roadmap that is not refined stays as it is."""
    if quality.rounds < 1:
        return roadmap, 0.0
    return roomy_roadmap(roadmap, query.checker, quality, progress)


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
