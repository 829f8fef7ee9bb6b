"""The result of a sweep: its paths with their intervals of beta, and what is written of them."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.files import StrPath, staged, write_json, write_whole
from planner.base.html import html_table
from planner.base.progress import Stopwatch, rounded
from planner.collision.checker import CollisionChecker
from planner.planning.run_record import RunRecord, run_record
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, SweepRequest
from planner.problem.run_schema import Nodes, Record
from planner.roadmap.record_text import RoadmapRecord, roadmap_text
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import save_roadmap
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.search.manipulability_floor import LayeredNetwork
from planner.view.page import Content, page, save_page
from planner.view.shown_path import ShownPath, path_rows

JSON_NAME, CSV_NAME, PAGE_NAME, ROADMAP_NAME = "sweep.json", "sweep.csv", "sweep.html", "roadmap.npz"
NAMES = (JSON_NAME, CSV_NAME, PAGE_NAME, ROADMAP_NAME)
Beta = Annotated[float, Field(ge=0, le=1)]


@dataclass(frozen=True, kw_only=True, eq=False)
class IntervalNumbers(Record):
    """What an interval of beta and its path measure; at beta the path costs (1 - beta) Omega + beta D."""

    beta_min: Beta
    beta_max: Beta
    manipulability_cost: Annotated[float, Field(description="Omega")]
    distance_cost: Annotated[float, Field(description="D")]
    w_min: float
    w_mean: float
    joint_length: Annotated[float, Field(description="rad")]
    workspace_length: Annotated[float, Field(description="m")]


@dataclass(frozen=True, kw_only=True, eq=False)
class IntervalRecord(IntervalNumbers):
    """A path and the betas that it is optimal for."""

    path_nodes: Nodes
    path: list[list[float]]
    """joint waypoints, rad (m where a joint slides), start first"""


@dataclass(frozen=True, kw_only=True, eq=False)
class SweepRecord(RunRecord):
    """What ``planner sweep`` writes as sweep.json; units rad, m and s."""

    complete: bool
    intervals: list[IntervalRecord]
    """sorted; they cover [0, 1] where complete, else they are those that are proven"""
    roadmap: RoadmapRecord
    solves: int
    max_error_vs_oracle: float | None
    timings_s: dict[str, float]


_NUMBERS = [each.name for each in fields(IntervalNumbers)]


@dataclass(frozen=True, kw_only=True, eq=False)
class Interval(IntervalNumbers):
    """One path and the betas [``beta_min``, ``beta_max``] that it is optimal for.

    ``path_nodes`` (k,) start first, ``path`` (k, dof) rad with continuous joints unwound. ``cost_to_go`` is the settled
    field at a beta of the interval (``cost_to_go.network.kernel.beta``).
    """

    path_nodes: Ints
    path: Floats
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
        """A table, one row per interval of beta."""
        record = sweep_record(self)
        rows, said = interval_rows(record), " ".join(summary_lines(record))
        caption = f"{self.robot.name} in {self.scene.name}. {self.outcome.value} {said}"
        cells = [[f"{value:.5g}" if isinstance(value, float) else str(value) for value in row.values()] for row in rows]
        return html_table(caption, cells, list(rows[0]) if rows else [])

    def shown_paths(self) -> list[ShownPath]:
        """The paths for a page; those that are proven so far where it was interrupted."""
        return [
            ShownPath(
                item.path,
                path_rows(self.robot, item.path, item.manipulability_cost, item.distance_cost),
                (item.beta_min, item.beta_max),
                None if self.layered is None else self.layered.on_roadmap(item.cost_to_go.x),
                (item.manipulability_cost, item.distance_cost),
            )
            for item in self.intervals
        ]

    def page(self) -> str:
        """The page as HTML text that needs nothing but a browser, whatever part of the trade-off is there."""
        paths, beta, message = self.shown_paths(), 0.5 if self.complete else 0.0, self.outcome.value
        if self.outcome is Outcome.SOLVED:
            message = f"{len(paths)} paths, each optimal in its interval of β."
            message = message if len(paths) > 1 else "One path is optimal for every β."
        details = [("roadmap", roadmap_text(self.roadmap.record(self.edges_removed).to_dict()))]
        if self.solves:
            details.append(("fields solved", str(self.solves)))
            details.append(("error against oracle", f"{self.max_error_vs_oracle:.1e} relative"))
        content = Content(
            self.robot,
            self.scene,
            message,
            self.roadmap.nodes[self.roadmap.starts[0]],
            details=details,
            roadmap=self.roadmap,
            paths=paths,
            current=next((k for k, shown in enumerate(paths) if shown.interval and beta <= shown.interval[1]), 0),
            beta=beta,
            floor=self.request.quality.min_manipulability,
        )
        return page(content)

    def save(self, folder: StrPath) -> None:
        """Write ``sweep.json``, ``sweep.csv``, ``sweep.html`` and ``roadmap.npz`` under ``folder``."""
        clock = Stopwatch(self.timings)
        self.save_page(folder, self.save_without_page(folder, clock), clock)

    def save_without_page(self, folder: StrPath, clock: Stopwatch) -> dict[str, Any]:
        """Write all but ``sweep.html``, take that of an earlier sweep away, and return the record, which comes last.

        The stages of ``clock`` go with the sweep's own.
        """
        clock.seconds.update(self.timings)
        with staged(Path(folder), (ROADMAP_NAME, CSV_NAME, PAGE_NAME, JSON_NAME)) as inner:
            with clock("files"):
                save_roadmap(self.roadmap, inner / ROADMAP_NAME)
                record = sweep_record(self)
                write_whole(inner / CSV_NAME, to_csv(record).encode())
            record["timings_s"] = clock.record()
            write_json(inner / JSON_NAME, record)
        return record

    def save_page(self, folder: StrPath, record: dict[str, Any], clock: Stopwatch) -> dict[str, Any]:
        """Write ``sweep.html``, and the record again with the seconds of ``clock``."""
        return save_page(self.page, Path(folder) / PAGE_NAME, record, Path(folder) / JSON_NAME, clock)


def sweep_record(tradeoff: Tradeoff) -> dict[str, Any]:
    """The trade-off as plain data, the keys of ``sweep.json``; units in rad, m and s."""
    return SweepRecord(
        **run_record(tradeoff.request, tradeoff.outcome, tradeoff.robot, tradeoff.scene),
        complete=tradeoff.complete,
        intervals=[_interval(interval) for interval in tradeoff.intervals],
        roadmap=tradeoff.roadmap.record(tradeoff.edges_removed),
        solves=tradeoff.solves,
        max_error_vs_oracle=tradeoff.max_error_vs_oracle,
        timings_s=rounded(tradeoff.timings),
    ).to_dict()


def _interval(interval: Interval) -> IntervalRecord:
    numbers = {name: getattr(interval, name) for name in _NUMBERS}
    return IntervalRecord(**numbers, path_nodes=interval.path_nodes.tolist(), path=interval.path.tolist())


def to_csv(record: dict[str, Any]) -> str:
    """One line per interval: its numbers to the last bit, and the nodes of its path with spaces between."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*_NUMBERS, "path_nodes"])
    for interval in record["intervals"]:
        writer.writerow([*(repr(interval[name]) for name in _NUMBERS), " ".join(map(str, interval["path_nodes"]))])
    return text.getvalue()


def interval_rows(record: dict[str, Any]) -> list[dict[str, Any]]:
    """The intervals as the terminal's table says them, narrow enough for 80 columns."""
    return [
        {
            "beta": range_text(interval["beta_min"], interval["beta_max"], " - "),
            "Omega": f"{interval['manipulability_cost']:.4f}",
            "D": f"{interval['distance_cost']:.4f}",
            "w min": f"{interval['w_min']:.2g}",
            "w mean": f"{interval['w_mean']:.3g}",
            "rad": f"{interval['joint_length']:.2f}",
            "m": f"{interval['workspace_length']:.2f}",
            "nodes": len(interval["path_nodes"]),
        }
        for interval in record["intervals"]
    ]


def summary_lines(record: dict[str, Any]) -> list[str]:
    """What the terminal says below the table."""
    lines = ["A path costs (1 - beta) Omega + beta D: manipulability and distance."] if record["intervals"] else []
    lines.append(f"Roadmap: {roadmap_text(record['roadmap'])}.")
    if record["solves"]:
        error = f"{record['max_error_vs_oracle']:.1e}"
        lines.append(f"{record['solves']} fields solved, largest error against the oracle {error} relative.")
    if not record["complete"] and record["intervals"]:
        lines.append(f"Proven up to beta = {record['intervals'][-1]['beta_max']:.5g} so far.")
    return lines
