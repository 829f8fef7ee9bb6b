"""The result of a sweep: its paths with their intervals of beta, and what is written of them."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.files import write_whole
from planner.collision.checker import CollisionChecker
from planner.planning.run import ROADMAP_NAME, Result, RunRecord
from planner.problem.outcome import Nodes, Outcome, Record, html_table
from planner.problem.request import PlanRequest, SweepRequest
from planner.roadmap.roadmap import Roadmap, RoadmapRecord
from planner.roadmap.storage import save_roadmap
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.search.manipulability_floor import LayeredNetwork
from planner.view.motion import ShownPath, path_rows
from planner.view.page import Page, command_line

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


_NUMBERS = [each.name for each in fields(IntervalNumbers)]


@dataclass(frozen=True, kw_only=True, eq=False)
class SweepRecord(RunRecord):
    """What ``planner sweep`` writes as sweep.json; units rad, m and s."""

    complete: bool
    intervals: list[IntervalRecord]
    """sorted; they cover [0, 1] where complete, else they are those that are proven"""
    roadmap: RoadmapRecord
    solves: int
    max_error_vs_oracle: float | None

    @property
    def csv(self) -> str:
        """One line per interval: its numbers to the last bit, and the nodes of its path with spaces between."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([*_NUMBERS, "path_nodes"])
        for item in self.intervals:
            writer.writerow([*(repr(getattr(item, name)) for name in _NUMBERS), " ".join(map(str, item.path_nodes))])
        return text.getvalue()

    @property
    def table(self) -> list[dict[str, Any]]:
        """A row per interval, narrow enough for 80 columns."""
        return [
            {
                "beta": range_text(item.beta_min, item.beta_max, " - "),
                "Omega": f"{item.manipulability_cost:.4f}",
                "D": f"{item.distance_cost:.4f}",
                "w min": f"{item.w_min:.2g}",
                "w mean": f"{item.w_mean:.3g}",
                "rad": f"{item.joint_length:.2f}",
                "m": f"{item.workspace_length:.2f}",
                "nodes": len(item.path_nodes),
            }
            for item in self.intervals
        ]

    @property
    def lines(self) -> list[str]:
        """The sentences below the table."""
        lines = ["A path costs (1 - beta) Omega + beta D: manipulability and distance."] if self.intervals else []
        lines.append(f"Roadmap: {self.roadmap.text}.")
        if self.solves:
            error = f"{self.max_error_vs_oracle:.1e}"
            lines.append(f"{self.solves} fields solved, largest error against the oracle {error} relative.")
        if not self.complete and self.intervals:
            lines.append(f"Proven up to beta = {self.intervals[-1].beta_max:.5g} so far.")
        return lines

    def html(self) -> str:
        """The table in a notebook cell."""
        table = self.table
        caption = f"{self.robot} in {self.scene}. {self.message} {' '.join(self.lines)}"
        cells = [[str(value) for value in row.values()] for row in table]
        return html_table(caption, cells, list(table[0]) if table else [])


@dataclass(frozen=True, kw_only=True, eq=False)
class Interval(IntervalNumbers):
    """One path and the betas [``beta_min``, ``beta_max``] that it is optimal for.

    ``path_nodes`` (k,) start first, ``path`` (k, dof) rad with continuous joints unwound. ``cost_to_go`` is the settled
    field at a beta of the interval (``cost_to_go.network.kernel.beta``).
    """

    path_nodes: Ints
    path: Floats
    cost_to_go: gabf.CostToGo

    def record(self) -> IntervalRecord:
        """What ``sweep.json`` holds of it."""
        numbers = {name: getattr(self, name) for name in _NUMBERS}
        return IntervalRecord(**numbers, path_nodes=self.path_nodes.tolist(), path=self.path.tolist())

    @property
    def betas(self) -> str:
        """The interval with as many digits as tell its ends apart: "0.238 to 0.479", "0.99979 to 1"."""
        return range_text(self.beta_min, self.beta_max)


def range_text(low: float, high: float, between: str = " to ") -> str:
    """Two numbers in [0, 1] with three digits behind the point, or as many as tell them apart."""
    apart = high - low
    digits = min(12, max(3, 1 - int(np.floor(np.log10(apart))))) if apart > 0.0 else 3
    return between.join(f"{value:.{digits}f}".rstrip("0").rstrip(".") for value in (low, high))


@dataclass(frozen=True, eq=False, repr=False)
class Tradeoff(Result[SweepRecord]):
    """The trade-off with everything it was made from.

    ``intervals`` are sorted and cover [0, 1] where ``complete``; where the sweep was interrupted those that are
    proven, from 0 up; none where there is no path. ``solves`` counts runs of the dynamics, ``max_error_vs_oracle`` is
    the largest relative error of all of them.
    """

    JSON: ClassVar = "sweep.json"
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
        """What ``sweep.json`` holds; units in rad, m and s."""
        return SweepRecord.of(
            self,
            self.robot,
            self.scene,
            complete=self.complete,
            intervals=[interval.record() for interval in self.intervals],
            roadmap=self.roadmap.record(self.edges_removed),
            solves=self.solves,
            max_error_vs_oracle=self.max_error_vs_oracle,
        )

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
        details = [("roadmap", self.record.roadmap.text)]
        if self.solves:
            details.append(("fields solved", str(self.solves)))
            details.append(("error against oracle", f"{self.max_error_vs_oracle:.1e} relative"))
        current = next((k for k, shown in enumerate(paths) if shown.interval and beta <= shown.interval[1]), 0)
        q = paths[current].path[0] if paths else self.roadmap.nodes[self.roadmap.starts[0]]
        command = command_line("sweep", self.request)
        page = Page(self.robot, self.scene, q, message, details, notes=self.end_notes, command=command)
        page.add_roadmap(self.roadmap)
        if paths:
            page.add_paths(paths, current, beta=beta, floor=self.request.quality.min_manipulability)
        return page.html()

    def _write(self, folder: Path) -> None:
        """Write ``roadmap.npz`` and ``sweep.csv`` into an empty ``folder``."""
        save_roadmap(self.roadmap, folder / ROADMAP_NAME)
        write_whole(folder / self.CSV, self.record.csv.encode())
