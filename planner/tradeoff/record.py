"""``sweep.json`` and ``sweep.csv``: the record of a trade-off, its schema, and its table."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import Field

from planner.base.arrays import combine_costs
from planner.base.yamlfile import read_text, validate
from planner.planning.base_result import RunRecord
from planner.problem.outcome import Nodes, Record, html_table, require_readable_version
from planner.problem.request import PlanQuality
from planner.roadmap.roadmap import RoadmapRecord
from planner.trajectory.file import parse_json

SWEEP_NAME = "sweep.json"
Beta = Annotated[float, Field(ge=0, le=1)]
_CLEARANCE = "m, the smallest distance of path and motion to anything that is checked; left out where nothing is near"
_GAIN = "share of the gain in w, as Omega counts it: what it saves of Omega is 1 at beta 0 and 0 at beta 1"
_ADDED = "share of the length that is added to D for that: 1 at beta 0, 0 at beta 1"
_KNEE = "the interval, counted from 0, farthest from the chord of the front; left out where there are fewer than three"


@dataclass(frozen=True, kw_only=True, eq=False)
class IntervalNumbers(Record):
    """The measures of an interval of beta and its path, which costs (1 - beta) Omega + beta D at beta."""

    beta_min: Beta
    beta_max: Beta
    manipulability_cost: Annotated[float, Field(description="Omega")]
    distance_cost: Annotated[float, Field(description="D")]
    w_min: float
    w_mean: float
    joint_length: Annotated[float, Field(description="rad")]
    workspace_length: Annotated[float, Field(description="m")]
    duration: Annotated[float | None, Field(description="of its motion, s; left out where there is none")] = None
    clearance: Annotated[float | None, Field(description=_CLEARANCE)] = None
    gain: Annotated[Beta | None, Field(description=_GAIN)] = None
    added_length: Annotated[Beta | None, Field(description=_ADDED)] = None

    def at(self, beta: float) -> float:
        """Return the path's cost at ``beta``."""
        return combine_costs(beta, self.manipulability_cost, self.distance_cost)

    @property
    def beta(self) -> float:
        """A beta of few digits in the middle of the interval."""
        digits = max(1, 1 - int(np.floor(np.log10(self.beta_max - self.beta_min))))
        return round((self.beta_min + self.beta_max) / 2, digits)

    def choice(self, is_knee: bool) -> dict[str, Any]:
        """Return the numbers of the interval for the page; m and s."""
        names = ("beta", "w_min", "duration", "clearance", "gain", "added_length", "buys")
        return {name: getattr(self, name) for name in names} | {"knee": is_knee}

    @property
    def buys(self) -> str:
        """The gain and the price of the beta as a sentence; empty where the ends of the front are unknown."""
        if self.gain is None or self.added_length is None:
            return ""
        shares = f"{100 * self.gain:.0f} % of the gain in w for {100 * self.added_length:.0f} % of the added length"
        return f"beta {self.beta:g}: {shares}"


@dataclass(frozen=True, kw_only=True, eq=False)
class IntervalRecord(IntervalNumbers):
    """A path and the betas at which it is optimal."""

    path_nodes: Nodes
    path: list[list[float]]
    """joint waypoints, rad (m where a joint slides), start first"""
    goal: str | None
    """which of the goals is reached"""
    trajectory: str | None = None
    """the file of its motion, next to this one"""


NUMBERS = [each.name for each in fields(IntervalNumbers)]


@dataclass(frozen=True, kw_only=True, eq=False)
class SweepRecord(RunRecord):
    """The content of sweep.json by ``planner sweep``; units rad, m and s."""

    complete: bool
    intervals: list[IntervalRecord]
    """sorted; they cover [0, 1] where complete, else they are those that are proven"""
    knee: Annotated[int | None, Field(description=_KNEE)] = None
    roadmap: RoadmapRecord
    clearance_kept: float
    """m beyond the margin that every edge keeps from which the paths were chosen"""
    solves: int
    max_error_vs_oracle: float | None

    @property
    def csv(self) -> str:
        """One line per interval: its numbers to the last bit, and the nodes of its path with spaces between."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([*NUMBERS, "path_nodes"])
        for item in self.intervals:
            numbers = (getattr(item, name) for name in NUMBERS)
            nodes = " ".join(map(str, item.path_nodes))
            writer.writerow([*("" if number is None else repr(number) for number in numbers), nodes])
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
                "rad": f"{item.joint_length:.2f}",
                "s": "" if item.duration is None else f"{item.duration:.2f}",
                "mm": "" if item.clearance is None else f"{1000 * item.clearance:.1f}",
                "gain": "" if item.gain is None else f"{100 * item.gain:.0f} %",
                "added": "" if item.added_length is None else f"{100 * item.added_length:.0f} %",
            }
            for item in self.intervals
        ]

    @property
    def theory(self) -> str:
        """The number of solved fields and their error."""
        if not self.solves:
            return ""
        return f"{self.solves} fields solved, largest relative error against Dijkstra {self.max_error_vs_oracle:.1e}."

    @property
    def lines(self) -> list[str]:
        """The sentences below the table."""
        lines = []
        if self.intervals:
            lines.append("Each path is the cheapest in this roadmap for its betas: (1 - beta) Omega + beta D is least.")
        if len(self.intervals) > 1 and self.complete:
            lines.append(
                "gain: share of what beta 0 gains in w over beta 1 (of Omega); added: of the length that it adds."
            )
        if self.knee is not None:
            item = self.intervals[self.knee]
            lines.append(f"The knee is {item.buys} (from {range_text(item.beta_min, item.beta_max)}).")
        lines.append(f"Roadmap: {self.roadmap.text}.")
        if not self.complete and self.intervals:
            lines.append(f"Proven up to beta = {self.intervals[-1].beta_max:.5g} so far.")
        return lines

    def html(self) -> str:
        """Return the table for a notebook cell."""
        table = self.table
        caption = f"{self.robot} in {self.scene}. {self.message} {' '.join(self.lines)}"
        cells = [[str(value) for value in row.values()] for row in table]
        return html_table(caption, cells, list(table[0]) if table else [])


def range_text(low: float, high: float, between: str = " to ") -> str:
    """Return two numbers in [0, 1] with three decimals, or as many as distinguish them."""
    apart = high - low
    digits = min(12, max(3, 1 - int(np.floor(np.log10(apart))))) if apart > 0.0 else 3
    return between.join(f"{value:.{digits}f}".rstrip("0").rstrip(".") for value in (low, high))


N = TypeVar("N", bound=IntervalNumbers)


def interval_at(intervals: Sequence[N], beta: float) -> tuple[N | None, str]:
    """Return the interval of ``beta`` among those of a sweep, or None, and a note where two meet there.

    Where two meet their paths cost the same, and the shorter one counts. Raises :class:`OptionError` for a beta outside
    [0, 1].
    """
    PlanQuality(beta=beta)  # refuses what is out of range
    here = [item for item in intervals if item.beta_min <= beta <= item.beta_max]
    if not here:
        return None, ""
    note = f"two paths of the roadmap cost the same at beta {beta:.12g}: the plan takes the shorter one"
    return here[-1], note if len(here) > 1 else ""  # D falls as beta grows


def read_sweep(folder: Path) -> SweepRecord:
    """Return the record in a folder of ``planner sweep``; :class:`FileError` if missing or damaged."""
    where = f"sweep {folder / SWEEP_NAME}"
    data = parse_json(read_text(folder / SWEEP_NAME, "sweep"), where)
    if isinstance(data, dict):
        require_readable_version(data, where)
    return validate(SweepRecord, data, where)
