"""``planner batch``: a row and a folder for each plan; a command that is repeated keeps the rows."""

from __future__ import annotations

import csv
import io
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from planner.base.errors import OptionError, PlannerError
from planner.base.files import make_folder, write_json, write_whole
from planner.base.interrupts import stop_requests
from planner.base.progress import QUIET, Progress
from planner.base.versions import software
from planner.batch.outcomes import CRASHED, REFUSED, SOLVED, TIMED_OUT
from planner.batch.parallel import measured_cases
from planner.batch.plans import Task, read_plans
from planner.planning.plan import plan
from planner.problem.request import SERIAL, PlanRequest, WorkersRequest
from planner.tradeoff.sweep import with_alternatives

CSV_NAME, ROW_NAME = "batch.csv", "row.json"
Row: TypeAlias = dict[str, Any]
_ASKED = ("robot", "scene", "start", "goal", "beta", "seed")
_RESULTS = ("goal_reached", "waypoints", "cost", "w_min", "w_mean", "length_rad", "length_m")
_RESULTS += ("nodes", "edges", "edges_certified", "roadmap_sha256")
_SHOWN = 20  # plans without a path that the report names


@dataclass(frozen=True)
class BatchResult:
    """The rows in the order of the plans, and a report; ``complete``: no plan is missing.

    A row has the options of a plan, ``asked``, a hash of them and of all files that are read, and the results, None
    where there are none. All columns but ``seconds`` are the same for any workers.
    """

    rows: tuple[Row, ...]
    report: str
    complete: bool


def run_batch(
    source: Path,
    out: Path,
    plain: PlanRequest,
    workers: WorkersRequest = SERIAL,
    pages: bool = False,
    time_limit: float = 600.0,
    progress: Progress = QUIET,
) -> BatchResult:
    """Plan all that ``source`` asks for (:func:`planner.batch.plans.read_plans`).

    Each plan has the folder ``out``/NAME, with ``plan.json``, ``roadmap.npz``, ``plan.html`` if ``pages``, and
    ``row.json``; ``batch.csv`` holds all rows. A row of the same options, files and software is kept, unless its plan
    crashed or ran out of time (s). A plan whose worker dies twice has crashed.
    """
    if not time_limit > 0:
        raise OptionError(f"time limit must be above 0 s, got {time_limit:g}.")
    tasks = read_plans(source, plain)
    rows = {task.name: row for task in tasks if (row := _kept_row(task, out)) is not None}
    missing = [task for task in tasks if task.name not in rows]
    progress("plans", len(rows), len(tasks))
    measure = partial(_measure_row, out=out.absolute(), pages=pages, time_limit=time_limit)
    for k, row in measured_cases(missing, measure, workers, progress):
        if row is None and not progress.stopped:
            row = _write_row(missing[k], out, {"message": "worker died, twice; lower --nodes or --jobs."})
        if row is not None:
            rows[missing[k].name] = row
            progress("plans", len(rows), len(tasks))
    found = tuple(rows[task.name] for task in tasks if task.name in rows)
    text = io.StringIO()
    table = csv.DictWriter(text, found[0] if found else (), lineterminator="\n")
    table.writeheader()
    table.writerows(found)
    make_folder(out)
    write_whole(out / CSV_NAME, text.getvalue().encode())
    return BatchResult(found, report_of(found, len(tasks), out), len(found) == len(tasks))


def report_of(rows: Sequence[Row], asked: int, out: Path) -> str:
    """How many were solved, and which were not."""
    others = [f"{row['name']}: {row['outcome']}. {row['message']}" for row in rows if row["outcome"] != SOLVED]
    lines = [f"{len(rows) - len(others)} of {asked} solved. Rows: {out / CSV_NAME}, folders: {out}/NAME."]
    if len(rows) < asked:
        lines.append(f"Interrupted: {asked - len(rows)} were not planned; the same command goes on from here.")
    more = [f"and {len(others) - _SHOWN} more."] if len(others) > _SHOWN else []
    return "\n".join([*lines, *others[:_SHOWN], *more, ""])


def _asked_columns(task: Task) -> Row:
    asked = {name: value for name, value in task.request.config().items() if name in _ASKED}
    return {"name": task.name, "asked": task.asked, "software": software(), **asked}


def _kept_row(task: Task, out: Path) -> Row | None:
    """The row in the plan's folder, if planning would give it again."""
    try:
        row = json.loads((out / task.name / ROW_NAME).read_text())
        same = row.items() >= _asked_columns(task).items()
    except (OSError, ValueError, AttributeError):  # missing, or damaged
        return None
    return row if same and row["outcome"] not in (CRASHED, TIMED_OUT) else None


def _write_row(task: Task, out: Path, results: Row) -> Row:
    blank = {"outcome": CRASHED, "message": "", **dict.fromkeys((*_RESULTS, "seconds"))}
    row = _asked_columns(task) | blank | results
    make_folder(out / task.name)
    write_json(out / task.name / ROW_NAME, row)
    return row


def _measure_row(task: Task, progress: Progress, out: Path, pages: bool, time_limit: float) -> Row | None:
    """Plan now, and write the folder; None where ``progress`` was stopped before the end."""
    begin, stops = time.perf_counter(), []

    def is_over() -> bool:
        if progress.stopped or time.perf_counter() - begin > time_limit:
            stops.append(True)
        return bool(stops)

    stop_requests.append(is_over)  # compiled functions ask these
    try:
        results = _plan(task.request, Progress(stop=is_over), out / task.name, pages)
    finally:
        stop_requests.remove(is_over)
    if stops and progress.stopped:
        return None
    if stops:
        results = {
            "outcome": TIMED_OUT,
            "message": f"stopped after {time_limit:g} s; raise --time-limit, lower --nodes.",
        }
    return _write_row(task, out, results | {"seconds": time.perf_counter() - begin})


def _plan(request: PlanRequest, progress: Progress, folder: Path, pages: bool) -> Row:
    """The results of a plan, whose folder is written unless it was stopped. A refusal or a crash is a result too."""
    try:
        found = plan(request, progress)
        if progress.stopped:
            return {}
        if pages:
            found = with_alternatives(found)
            found.save(folder)
        else:
            found.save_without_page(folder)
    except PlannerError as error:
        return {"outcome": REFUSED, "message": str(error)}
    except Exception as error:
        return {"message": f"{type(error).__name__}: {error}"}
    record, values = found.record, dict[str, Any].fromkeys(_RESULTS)
    values |= {"goal_reached": record.goal, "waypoints": len(record.path) or None}
    if record.cost is not None:
        values["cost"] = record.cost.total
    if record.manipulability is not None:
        values |= {"w_min": record.manipulability.min, "w_mean": record.manipulability.mean}
    if record.path_length is not None:
        values |= {"length_rad": record.path_length.joint, "length_m": record.path_length.workspace}
    roadmap = record.roadmap
    values |= {"nodes": roadmap.nodes, "edges": roadmap.edges, "edges_certified": roadmap.edges_certified}
    return {"outcome": record.outcome, "message": record.message, **values, "roadmap_sha256": roadmap.sha256}
