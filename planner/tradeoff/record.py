"""``sweep.json``: the record of a trade-off, its schema in types and docstrings, and its table."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass, fields
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from planner.base.html import html_table
from planner.planning.run import RunRecord
from planner.problem.outcome import Nodes, Record
from planner.roadmap.roadmap import RoadmapRecord

Beta = Annotated[float, Field(ge=0, le=1)]


@dataclass(frozen=True, kw_only=True, eq=False)
class IntervalRecord(Record):
    """A path and the betas that it is optimal for."""

    beta_min: Beta
    beta_max: Beta
    manipulability_cost: float
    """Omega"""
    distance_cost: float
    """D"""
    w_min: float
    w_mean: float
    joint_length: float
    """rad"""
    workspace_length: float
    """m"""
    path_nodes: Nodes
    path: list[list[float]]
    """joint waypoints, rad (m where a joint slides), start first"""


NUMBERS = [field.name for field in fields(IntervalRecord) if not field.name.startswith("path")]


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
        writer.writerow([*NUMBERS, "path_nodes"])
        for item in self.intervals:
            writer.writerow([*(repr(getattr(item, name)) for name in NUMBERS), " ".join(map(str, item.path_nodes))])
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


def range_text(low: float, high: float, between: str = " to ") -> str:
    """Two numbers in [0, 1] with three digits behind the point, or as many as tell them apart."""
    apart = high - low
    digits = min(12, max(3, 1 - int(np.floor(np.log10(apart))))) if apart > 0.0 else 3
    return between.join(f"{value:.{digits}f}".rstrip("0").rstrip(".") for value in (low, high))
