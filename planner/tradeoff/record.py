"""What a sweep writes, ``sweep.json``, ``sweep.csv`` and ``roadmap.npz``, and how a later sweep goes on from it."""

from __future__ import annotations

import csv
import io
import json
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pydantic

from planner.base.arrays import frozen
from planner.base.beside import hashes
from planner.base.errors import FileError
from planner.base.files import is_file, staged, write_json, write_whole
from planner.base.formats import require_readable_version
from planner.base.html import html_table
from planner.base.progress import Stopwatch, rounded
from planner.base.yamlfile import Number, Strict, Whole, read_text, shown, validate
from planner.models.run_record import run_record
from planner.problem.request import SweepRequest
from planner.roadmap.record_text import roadmap_text
from planner.roadmap.storage import load_roadmap, save_roadmap
from planner.tradeoff.nondominated import Front
from planner.tradeoff.page import sweep_page
from planner.tradeoff.sweep import Checkpoint, Tradeoff, range_text, reached_by_beta
from planner.view.page import save_page

JSON_NAME, CSV_NAME, PAGE_NAME, ROADMAP_NAME = "sweep.json", "sweep.csv", "sweep.html", "roadmap.npz"
NAMES = (JSON_NAME, CSV_NAME, PAGE_NAME, ROADMAP_NAME)
_NUMBERS = (
    *("beta_min", "beta_max", "manipulability_cost", "distance_cost"),
    *("w_min", "w_mean", "joint_length", "workspace_length"),
)


def sweep_record(tradeoff: Tradeoff) -> dict[str, Any]:
    """The trade-off as plain data, the keys of ``sweep.json``; units in rad, m and s.

    ``intervals`` cover [0, 1] where ``complete`` is true; where not, they are those that are proven. ``search`` is
    what --resume goes on from.
    """
    return {
        **run_record(tradeoff.request, tradeoff.outcome, tradeoff.robot, tradeoff.scene),
        "complete": tradeoff.complete,
        "intervals": [
            {
                **{name: getattr(interval, name) for name in _NUMBERS},
                "path_nodes": interval.path_nodes.tolist(),
                "path": interval.path.tolist(),
            }
            for interval in tradeoff.intervals
        ],
        "front": None if tradeoff.front is None else _front_record(tradeoff.front, tradeoff),
        "roadmap": tradeoff.roadmap.record(tradeoff.edges_removed),
        "solves": tradeoff.solves,
        "max_error_vs_oracle": tradeoff.max_error_vs_oracle,
        "search": {
            "roadmap_whole": tradeoff.grown,
            "settled": tradeoff.settled,
            "barred": [list(arc) for arc in tradeoff.barred],
            "found": [{"beta": beta, "path_nodes": nodes.tolist()} for beta, nodes in tradeoff.found],
        },
        "timings_s": rounded(tradeoff.timings),
    }


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
            record["files"] = hashes(inner, (ROADMAP_NAME, CSV_NAME))
        record["timings_s"] = clock.record()
        write_json(inner / JSON_NAME, record)
    return record


def save_sweep_page(tradeoff: Tradeoff, folder: Path, record: dict[str, Any], clock: Stopwatch) -> dict[str, Any]:
    """Write ``sweep.html``, and the record again with its hash and the seconds of ``clock``."""
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


def read_checkpoint(request: SweepRequest, folder: Path) -> Checkpoint:
    """How far the sweep in ``folder`` came; :class:`FileError` unless it is a whole one of the same request."""
    path = folder / JSON_NAME
    kept = _read(path)
    _require_same_request(kept.config, json.loads(json.dumps(request.to_dict())), path)
    if not kept.search.roadmap_whole:
        return Checkpoint(folder / ROADMAP_NAME)
    roadmap = load_roadmap(folder / ROADMAP_NAME)
    if roadmap.sha256 != kept.roadmap.sha256:
        raise FileError(f"{path} was made on another roadmap than the one beside it: sweep anew without --resume.")
    found = tuple((support.beta, frozen(support.path_nodes, np.int64)) for support in kept.search.found)
    barred = tuple(kept.search.barred)
    return Checkpoint(folder / ROADMAP_NAME, roadmap, found, kept.search.settled, kept.roadmap.edges_removed, barred)


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
    if (front := record["front"]) is not None:
        count, beyond = len(front["points"]), front["beyond_every_beta"]
        stopped = f" The search was stopped after {front['labels']} labels: there may be more."
        more = "" if front["complete"] else stopped
        lines.append(f"{count} non-dominated paths, {beyond or 'none'} of them out of reach of every beta.{more}")
    return lines


def _front_record(front: Front, tradeoff: Tradeoff) -> dict[str, Any]:
    reached = reached_by_beta(front.points, tradeoff.intervals)
    names = ("manipulability_cost", "distance_cost", "optimal_at_some_beta", "path_nodes")
    rows = zip(*front.points.T.tolist(), reached.tolist(), (nodes.tolist() for nodes in front.paths), strict=True)
    return {
        "complete": front.complete,
        "labels": front.labels,
        "beyond_every_beta": int((~reached).sum()),
        "points": [dict(zip(names, row, strict=True)) for row in rows],
    }


_Node = Annotated[Whole, pydantic.Field(ge=0)]


class _Support(Strict):
    beta: Number = pydantic.Field(ge=0, le=1)
    path_nodes: list[Whole] = pydantic.Field(min_length=1)


class _Search(Strict):
    """The part of ``sweep.json`` that --resume goes on from."""

    roadmap_whole: bool
    settled: Whole = pydantic.Field(ge=0)
    barred: list[tuple[_Node, _Node]]
    found: list[_Support]

    @pydantic.model_validator(mode="after")
    def _is_a_run_of_supports(self) -> _Search:
        betas = [support.beta for support in self.found]
        ends = betas[:1] in ([], [0.0]) and (len(betas) < 2 or betas[-1] == 1.0)
        if not ends or any(a > b for a, b in pairwise(betas)) or self.settled > max(0, len(betas) - 1):
            raise ValueError("its paths are not in the order of beta from 0 to 1")
        return self


class _Roadmap(pydantic.BaseModel):
    sha256: str
    edges_removed: Whole


class _Kept(pydantic.BaseModel):
    """What is read of ``sweep.json`` again."""

    config: dict[str, Any]
    roadmap: _Roadmap
    search: _Search


def _read(path: Path) -> _Kept:
    if not is_file(path):
        raise FileError(f"{path} not found, so there is no sweep to go on from: leave --resume out.")
    try:
        data = json.loads(read_text(path, "sweep"))
    except (ValueError, RecursionError):
        raise FileError(f"{path} is damaged: it is no JSON; sweep anew without --resume.") from None
    if isinstance(data, dict):
        require_readable_version(data, str(path))
    return validate(_Kept, data, f"{path} is damaged")


def _require_same_request(earlier: dict[str, Any], now: dict[str, Any], path: Path) -> None:
    other = sorted(key for key in earlier.keys() | now.keys() if earlier.get(key) != now.get(key))
    if other:
        option = "--" + other[0].replace("_", "-")[:100]
        was, asked = (shown(config.get(other[0])) for config in (earlier, now))
        raise FileError(f"{path} was made with {option} {was}, not {asked}: repeat its options, or leave --resume out.")
