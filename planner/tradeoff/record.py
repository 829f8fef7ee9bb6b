"""What a sweep writes: ``sweep.json``, ``sweep.csv`` and ``roadmap.npz``."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from planner.base.files import staged, write_json, write_whole
from planner.base.html import html_table
from planner.base.progress import Stopwatch, rounded
from planner.planning.run_record import RunRecord, run_record
from planner.problem.run_schema import Nodes, Record
from planner.roadmap.record_text import RoadmapRecord, roadmap_text
from planner.roadmap.storage import save_roadmap
from planner.tradeoff.page import sweep_page
from planner.tradeoff.sweep import Interval, Tradeoff, range_text
from planner.view.page import save_page

JSON_NAME, CSV_NAME, PAGE_NAME, ROADMAP_NAME = "sweep.json", "sweep.csv", "sweep.html", "roadmap.npz"
NAMES = (JSON_NAME, CSV_NAME, PAGE_NAME, ROADMAP_NAME)
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


_NUMBERS = [field.name for field in fields(IntervalRecord) if not field.name.startswith("path")]


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


def save_sweep(tradeoff: Tradeoff, folder: Path, clock: Stopwatch | None = None) -> dict[str, Any]:
    """Write the four files; the stages of ``clock`` go with the sweep's own. Returns the record that was written."""
    clock = clock or Stopwatch(tradeoff.timings)
    return save_sweep_page(tradeoff, folder, save_sweep_without_page(tradeoff, folder, clock), clock)


def save_sweep_without_page(tradeoff: Tradeoff, folder: Path, clock: Stopwatch) -> dict[str, Any]:
    """Write all but ``sweep.html``, take that of an earlier sweep away, and return the record, which comes last."""
    clock.seconds.update(tradeoff.timings)
    with staged(folder, (ROADMAP_NAME, CSV_NAME, PAGE_NAME, JSON_NAME)) as inner:
        with clock("files"):
            save_roadmap(tradeoff.roadmap, inner / ROADMAP_NAME)
            record = sweep_record(tradeoff)
            write_whole(inner / CSV_NAME, to_csv(record).encode())
        record["timings_s"] = clock.record()
        write_json(inner / JSON_NAME, record)
    return record


def save_sweep_page(tradeoff: Tradeoff, folder: Path, record: dict[str, Any], clock: Stopwatch) -> dict[str, Any]:
    """Write ``sweep.html``, and the record again with the seconds of ``clock``."""
    return save_page(lambda: sweep_page(tradeoff), folder / PAGE_NAME, record, folder / JSON_NAME, clock)


def sweep_table(tradeoff: Tradeoff) -> str:
    """A trade-off as an HTML table, one row per interval of beta."""
    record = sweep_record(tradeoff)
    rows, said = interval_rows(record), " ".join(summary_lines(record))
    caption = f"{tradeoff.robot.name} in {tradeoff.scene.name}. {tradeoff.outcome.value} {said}"
    cells = [[f"{value:.5g}" if isinstance(value, float) else str(value) for value in row.values()] for row in rows]
    return html_table(caption, cells, list(rows[0]) if rows else [])


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
