"""The result of a sweep: paths with intervals of beta, a plan at any beta, and the files."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints, frozen
from planner.base.errors import FileError
from planner.base.files import StrPath, write_whole
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.collision.checker import CollisionChecker
from planner.planning.base_result import ROADMAP_NAME, Result
from planner.planning.result import Plan
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, SweepRequest
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import load_roadmap, reopen_plan, save_roadmap
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.search.manipulability_floor import LayeredNetwork
from planner.search.network import PathCost, at_beta, build_network
from planner.search.search import RoadmapPaths, make_recheck
from planner.tradeoff.envelope import EnvelopeSearch, SupportInterval, find_knee, front_shares, support_intervals
from planner.tradeoff.record import (
    NUMBERS,
    SWEEP_NAME,
    IntervalNumbers,
    IntervalRecord,
    SweepRecord,
    interval_at,
    range_text,
    read_sweep,
)
from planner.trajectory.measure import measure_path
from planner.trajectory.trajectory import Trajectory
from planner.view.motion import ShownPath, path_rows, sample_motion
from planner.view.page import Page, command_line


@dataclass(frozen=True, kw_only=True, eq=False)
class Interval(IntervalNumbers):
    """A path and the betas [``beta_min``, ``beta_max``] at which it is optimal in the roadmap.

    ``path_nodes`` (k,) start first, ``path`` (k, dof) rad with continuous joints unwound. ``cost_to_go`` is the settled
    field at a beta of the interval (``cost_to_go.network.kernel.beta``), ``trajectory`` the motion along the path.
    """

    path_nodes: Ints
    path: Floats
    cost_to_go: gabf.CostToGo
    goal: str | None = None  # the text of the goal that the path reaches
    trajectory: Trajectory | None = None

    def record(self, name: str) -> IntervalRecord:
        """Return the record for ``sweep.json``; the motion is in the file ``name``."""
        return IntervalRecord(
            **{number: getattr(self, number) for number in NUMBERS},
            path_nodes=self.path_nodes.tolist(),
            path=self.path.tolist(),
            goal=self.goal,
            trajectory=None if self.trajectory is None else name,
        )

    @property
    def betas(self) -> str:
        """The interval with enough digits to distinguish its ends: "0.238 to 0.479", "0.99979 to 1"."""
        return range_text(self.beta_min, self.beta_max)


@dataclass(frozen=True, eq=False, repr=False)
class Tradeoff(Result[SweepRecord]):
    """The trade-off of one roadmap's paths and its inputs; :meth:`at` is the plan at a beta.

    ``intervals`` are sorted and cover [0, 1] if ``complete``; after an interruption they are the proven ones, from 0
    up; none without a path. ``solves`` counts runs of the dynamics, ``max_error_vs_oracle`` is their largest relative
    error.
    """

    JSON: ClassVar = SWEEP_NAME
    PAGE: ClassVar = "sweep.html"
    CSV: ClassVar = "sweep.csv"
    FILES: ClassVar = (ROADMAP_NAME, CSV, PAGE, JSON)

    request: SweepRequest | PlanRequest
    checker: CollisionChecker
    roadmap: Roadmap
    layered: LayeredNetwork | None = None
    intervals: tuple[Interval, ...] = ()
    complete: bool = False
    solves: int = 0
    max_error_vs_oracle: float | None = None
    edges_removed: int = 0
    clearance: float = 0.0  # m beyond the margin that every path keeps

    def __repr__(self) -> str:
        count = f"{len(self.intervals)} intervals of beta"
        return f"<Tradeoff: {self.robot.name} in {self.scene.name}, {self.outcome.key}, {count}>"

    def _repr_html_(self) -> str:
        return self.record.html()

    @property
    def robot(self) -> Robot:
        return self.checker.robot

    @property
    def scene(self) -> Scene:
        return self.checker.world.scene

    @cached_property
    def record(self) -> SweepRecord:
        """The content of ``sweep.json``; units in rad, m and s."""
        return SweepRecord.from_run(
            self,
            self.robot,
            self.scene,
            complete=self.complete,
            intervals=[item.record(name) for name, item in zip(self._motions, self.intervals, strict=True)],
            knee=self._knee,
            clearance_kept=self.clearance,
            roadmap=self.roadmap.record(self.edges_removed),
            solves=self.solves,
            max_error_vs_oracle=self.max_error_vs_oracle,
        )

    @classmethod
    def load(cls, folder: StrPath) -> Tradeoff:
        """The trade-off that ``planner sweep`` or :meth:`save` wrote into ``folder``.

            Tradeoff.load("sweep").at(0.2)

        Its roadmap is searched again, so fields and proofs are there too; motions come from their files. Raises
        :class:`FileError` where a file is missing, or robot, scene or paths are not those of the sweep any more.
        """
        folder = Path(folder)
        record = read_sweep(folder)
        checker, roadmap = reopen_plan(record.config, folder / ROADMAP_NAME), load_roadmap(folder / ROADMAP_NAME)
        request = SweepRequest.from_config(record.config)
        known = {"clearance": record.clearance_kept, "edges_removed": record.roadmap.edges_removed}
        tradeoff = add_intervals(cls(request, Outcome.INTERRUPTED, checker, roadmap, **known))
        intervals = list(tradeoff.intervals)
        for k, known in enumerate(record.intervals):
            if k >= len(intervals) or intervals[k].path_nodes.tolist() != known.path_nodes:
                raise FileError(f"{folder / cls.JSON} has other paths than its roadmap gives now: sweep again.")
            motion = None if known.trajectory is None else Trajectory.load(folder / known.trajectory)
            own = {"goal": known.goal, "duration": known.duration, "clearance": known.clearance}
            intervals[k] = replace(intervals[k], trajectory=motion, **own)
        return replace(tradeoff, intervals=tuple(intervals))

    def at(self, beta: float) -> Plan:
        """The plan at ``beta``: the path of its interval with its motion, and the field of this beta.

            tradeoff.at(0.2).save("out")

        Where two intervals meet their paths cost the same: the plan takes the shorter one, and a note says so. An
        interrupted sweep has no path for a beta that it did not reach. Raises :class:`OptionError` for a beta outside
        [0, 1].
        """
        item, note = interval_at(self.intervals, beta)
        if item is None:
            return self._without_path(beta)
        plan, clock = self.plan_along(item, beta), Stopwatch()
        with clock("gabf"):
            network = at_beta(item.cost_to_go.network, beta)
            law = gabf.law_from_name(plan.request.quality.law, plan.request.quality.prescribed_time)
            field = gabf.solve(network, law=law, x0=None if law.needs_overestimate else item.cost_to_go.x)
        shown = self._shown if self.complete else ()
        notes = (*plan.end_notes, note) if note else plan.end_notes
        return replace(plan, cost_to_go=field, alternatives=shown, end_notes=notes, timings=clock.seconds)

    def plan_along(self, item: Interval, beta: float) -> Plan:
        """Return the plan at ``beta`` along an interval's path, without a field."""
        cost = PathCost(item.at(beta), item.manipulability_cost, item.distance_cost, beta)
        own = {"path": item.path, "path_nodes": item.path_nodes, "goal": item.goal, "trajectory": item.trajectory}
        return replace(self._without_path(beta), outcome=Outcome.SOLVED, cost=cost, **own)

    def _without_path(self, beta: float) -> Plan:
        request = PlanRequest.from_options(**self.request.values() | {"beta": beta})
        known = {"layered": self.layered, "clearance_kept": self.clearance, "edges_removed": self.edges_removed}
        return Plan(request, self.outcome, self.checker, self.roadmap, **known, end_notes=self.end_notes)

    @property
    def knee(self) -> Interval | None:
        """The interval at the knee of the front, see :func:`planner.tradeoff.envelope.find_knee`.

            tradeoff.knee and tradeoff.knee.buys

        None for fewer than three intervals, and where the sweep is not complete.
        """
        return None if self._knee is None else self.intervals[self._knee]

    @property
    def _knee(self) -> int | None:
        return find_knee([(item.gain, item.added_length) for item in self.intervals])

    def page_paths(self) -> list[ShownPath]:
        """The paths for a page; those that are proven so far where it was interrupted."""
        return list(self._shown)

    @cached_property
    def _shown(self) -> tuple[ShownPath, ...]:
        return tuple(
            ShownPath(
                item.path,
                path_rows(self.robot, item.path, item.manipulability_cost, item.distance_cost),
                (item.beta_min, item.beta_max),
                None if self.layered is None else self.layered.on_roadmap(item.cost_to_go.x),
                (item.manipulability_cost, item.distance_cost),
                None if item.trajectory is None else sample_motion(item.trajectory, self.checker),
                item.choice(k == self._knee),
            )
            for k, item in enumerate(self.intervals)
        )

    def page(self) -> str:
        """Return the page as HTML text that needs nothing but a browser, also of an incomplete trade-off."""
        paths, beta, message = self.page_paths(), 0.5 if self.complete else 0.0, self.outcome.value
        if self.outcome is Outcome.SOLVED:
            message = f"{len(paths)} paths of this roadmap, each optimal in its interval of β."
            message = message if len(paths) > 1 else "One path of this roadmap is optimal for every β."
        details = [("roadmap", self.record.roadmap.text)]
        if self.solves:
            details.append(("fields solved", str(self.solves)))
            details.append(("error against oracle", f"{self.max_error_vs_oracle:.1e} relative"))
        current = next((k for k, shown in enumerate(paths) if shown.interval and beta <= shown.interval[1]), 0)
        q = paths[current].path[0] if paths else self.roadmap.nodes[self.roadmap.starts[0]]
        timed = not paths or any(item.trajectory is not None for item in self.intervals)
        command = command_line("sweep" if timed else "sweep --no-timing", self.request)
        page = Page(self.robot, self.scene, q, message, details, notes=self.end_notes, command=command)
        page.add_roadmap(self.roadmap)
        if paths:
            page.add_paths(paths, current, beta=beta, floor=self.request.quality.min_manipulability)
        return page.html()

    def files(self, folder: Path) -> Sequence[str]:
        """Return the names of all written files, and of an earlier sweep's motions in ``folder``."""
        there = sorted(path.name for path in folder.glob("trajectory-*.json"))
        old = [name for name in there if re.fullmatch(r"trajectory-\d+\.json", name)]
        return [*dict.fromkeys([*old, *self._motions]), *self.FILES]

    @property
    def _motions(self) -> list[str]:
        """The names of the files of the intervals' motions."""
        return [f"trajectory-{k}.json" for k in range(1, len(self.intervals) + 1)]

    def _write(self, folder: Path) -> None:
        """Write ``roadmap.npz``, ``sweep.csv`` and the motions into an empty ``folder``."""
        save_roadmap(self.roadmap, folder / ROADMAP_NAME)
        write_whole(folder / self.CSV, self.record.csv.encode())
        for name, item in zip(self._motions, self.intervals, strict=True):
            if item.trajectory is not None:
                item.trajectory.save(folder / name, self.robot.name, self.scene.name)


def add_intervals(draft: Tradeoff, clock: Stopwatch | None = None, progress: Progress = QUIET) -> Tradeoff:
    """Return the trade-off with the proven intervals of its roadmap's paths, until a stop is requested.

    A path that fails its recheck is removed, and the search starts again.
    """
    quality, clock = draft.request.quality, clock or Stopwatch()
    with clock("costs"):
        network = build_network(draft.roadmap, quality.objective_at(0.5), draft.clearance)
        look, floor = make_recheck(draft.checker, draft.roadmap, progress=progress), quality.min_manipulability
        paths = RoadmapPaths(draft.roadmap, draft.robot, network, floor, look)
    search = EnvelopeSearch(paths, gabf.law_from_name(quality.law, quality.prescribed_time), clock)
    while not search.is_done and not progress.stopped:
        search.step()
        progress("beta", int(100 * search.reach), 100)
    draft = replace(
        draft,
        roadmap=paths.roadmap,
        layered=paths.layered,
        edges_removed=draft.edges_removed + int((~paths.kept).sum()),
        solves=search.solves,
        max_error_vs_oracle=search.max_error if search.solves else None,
    )
    if not search.is_connected:
        return replace(draft, outcome=Outcome.TOO_SINGULAR if floor > 0 else Outcome.NO_PATH)
    with clock("measures"):
        known = support_intervals(search.supports[: search.settled + 1])
        known = known if search.is_done else known[:-1]
        steps, on_roadmap = [piece.support.nodes for piece in known], paths.layered.roadmap_node
        rows = [paths.waypoints(nodes) for nodes in steps]
        numbers = interval_numbers(known, rows, draft.robot, search.is_done)
        intervals = tuple(
            Interval(**vars(item), path_nodes=frozen(on_roadmap[nodes], np.int64), path=path, cost_to_go=_run(piece))
            for item, nodes, path, piece in zip(numbers, steps, rows, known, strict=True)
        )
    outcome = Outcome.SOLVED if search.is_done else Outcome.INTERRUPTED
    return replace(draft, intervals=intervals, complete=search.is_done, outcome=outcome)


def _run(piece: SupportInterval) -> gabf.CostToGo:
    assert piece.support.cost_to_go is not None  # a sweep runs the dynamics
    return piece.support.cost_to_go


def interval_numbers(
    known: Sequence[SupportInterval], paths: Sequence[Floats], robot: Robot, complete: bool
) -> list[IntervalNumbers]:
    """Return the measures of intervals by their paths (k, dof); with shares if the front is ``complete``."""
    costs = np.array([(piece.support.manipulability, piece.support.distance) for piece in known]).reshape(-1, 2)
    shares = front_shares(costs).tolist() if complete else [(None, None)] * len(known)
    return [
        IntervalNumbers(
            beta_min=piece.beta_min,
            beta_max=piece.beta_max,
            manipulability_cost=piece.support.manipulability,
            distance_cost=piece.support.distance,
            **asdict(measure_path(robot, path)),
            gain=gain,
            added_length=added,
        )
        for piece, path, (gain, added) in zip(known, paths, shares, strict=True)
    ]
