"""``planner batch``: every plan in a process of its own, with a row and a folder each, resumable."""

from __future__ import annotations

import json
import os
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import pydantic

from planner.base.errors import OptionError
from planner.base.files import make_folder, write_json, write_whole
from planner.base.progress import QUIET, Progress
from planner.base.tables import markdown_table, median
from planner.batch.outcomes import CRASHED, SOLVED, TIMED_OUT
from planner.batch.results import Results, to_csv
from planner.batch.tasks import CSV_NAME, Task, read_tasks
from planner.problem.request import SERIAL, PlanRequest, WorkersRequest
from planner.processes.parallel import measured_cases
from planner.processes.process import Ended, run_module
from planner.processes.source import software

ROW_NAME = "row.json"
_SHOWN = 20  # plans without a path that the report names


@dataclass(frozen=True)
class Row:
    """One plan: what was asked, then what came of it, None where there is nothing.

    ``asked`` is a hash of the options and of all files that are read, ``seconds`` those of its process; all other
    columns are the same whenever and beside whatever it is planned.
    """

    name: str
    asked: str
    software: str
    robot: str
    scene: str
    start: str
    goal: str
    beta: float
    seed: int
    outcome: str = CRASHED
    message: str = ""
    goal_reached: str | None = None
    waypoints: int | None = None
    cost: float | None = None
    w_min: float | None = None
    w_mean: float | None = None
    length_rad: float | None = None
    length_m: float | None = None
    nodes: int | None = None
    edges: int | None = None
    edges_certified: int | None = None
    roadmap_sha256: str | None = None
    seconds: float | None = None


def run_batch(
    source: Path,
    out: Path,
    plain: PlanRequest,
    workers: WorkersRequest = SERIAL,
    pages: bool = False,
    time_limit: float = 600.0,
    progress: Progress = QUIET,
) -> Results[Row]:
    """Plan all that ``source`` asks for (:func:`planner.batch.tasks.read_tasks`), several at once.

    Each has a process of its own and the folder ``out``/NAME, with ``plan.json``, ``roadmap.npz``, ``plan.html`` if
    ``pages``, and ``row.json``; ``batch.csv`` holds all rows. A plan whose folder holds a row of the same options,
    files and software is not planned again, unless it crashed or ran out of time. One that is killed from outside is
    tried once more. The rows do not depend on the ``workers``, but for their seconds.
    """
    if not time_limit > 0:
        raise OptionError("give a time limit above 0 s.")
    tasks = read_tasks(source, plain)
    make_folder(out)
    rows = {task.name: row for task in tasks if (row := _kept(task, out)) is not None}
    missing = [task for task in tasks if task.name not in rows]
    progress("plans", len(rows), len(tasks))
    measure = partial(_planned, out=out.absolute(), pages=pages, time_limit=time_limit)
    for k, row in measured_cases(missing, measure, workers, progress, isolated=True):
        if row is not None:
            rows[missing[k].name] = row
            progress("plans", len(rows), len(tasks))
    there = [rows[task.name] for task in tasks if task.name in rows]
    write_whole(out / CSV_NAME, to_csv(there, Row).encode())
    complete = len(there) == len(tasks)
    return Results(tuple(there), report_of(there, len(tasks), out), complete)


def report_of(rows: Sequence[Row], asked: int, out: Path) -> str:
    """How many were solved, the medians of those, and which were not; Markdown."""
    solved = [row for row in rows if row.outcome == SOLVED]
    lines = [f"{len(solved)} of {asked} solved. Rows: {out / CSV_NAME}, folders: {out}/NAME."]
    if len(rows) < asked:
        lines += ["", f"Interrupted: {asked - len(rows)} were not planned; the same command goes on from here."]
    if solved:
        medians = {name: median(getattr(row, name) for row in solved) for name in ("w_min", "length_rad", "seconds")}
        lines += ["", "Median: " + ", ".join(f"{name} {value:.3g}" for name, value in medians.items()) + "."]
    others = [row for row in rows if row.outcome != SOLVED]
    if others:
        counts = Counter(row.outcome for row in others)
        lines += ["", ", ".join(f"{count} {outcome}" for outcome, count in counts.items()) + ":", ""]
        lines += markdown_table(
            ("plan", "outcome", "message"), [(r.name, r.outcome, r.message) for r in others[:_SHOWN]], 3
        )
        if len(others) > _SHOWN:
            lines.append(f"and {len(others) - _SHOWN} more.")
    return "\n".join(lines) + "\n"


def _blank(task: Task) -> Row:
    asked = task.options
    names = ("robot", "scene", "start", "goal", "beta", "seed")
    return Row(task.name, task.asked, software(), *(asked[name] for name in names))


def _kept(task: Task, out: Path) -> Row | None:
    """The row in the plan's folder, if it would come out the same now."""
    path = out / task.name / ROW_NAME
    if not os.path.isfile(path):
        return None
    try:
        row = pydantic.TypeAdapter(Row).validate_python(json.loads(path.read_text()))
        json.dumps(asdict(row), ensure_ascii=False, allow_nan=False).encode()
    except (OSError, ValueError, TypeError, RecursionError):
        return None  # of another version, cut off, or of what is no number or no text: planned again
    if row.outcome == SOLVED and None in (row.w_min, row.length_rad, row.seconds):
        return None
    blank = _blank(task)
    same = (row.name, row.asked, row.software) == (blank.name, blank.asked, blank.software)
    return row if same and row.outcome not in (CRASHED, TIMED_OUT) else None


def _planned(task: Task, progress: Progress, out: Path, pages: bool, time_limit: float) -> Row | None:
    """The row of a plan that is planned now, None where stopped."""
    blank, folder = _blank(task), out / task.name
    with tempfile.TemporaryDirectory() as place:
        answer = Path(place) / ROW_NAME
        arguments = [str(answer), str(folder), json.dumps(task.options), *(["page"] if pages else [])]
        ended = run_module("planner.batch.case", arguments, progress, time_limit, tries=2)
        if ended.code is None and not ended.over_time:
            return None
        row = _row(blank, ended, answer, time_limit)
    make_folder(folder)
    write_json(folder / ROW_NAME, asdict(row))
    return row


def _row(blank: Row, ended: Ended, answer: Path, time_limit: float) -> Row:
    if ended.over_time:
        message = f"killed after {time_limit:g} s; raise --time-limit or lower --nodes."
        return replace(blank, outcome=TIMED_OUT, message=message, seconds=ended.seconds)
    if ended.code != 0:
        return replace(blank, message=ended.fault, seconds=ended.seconds)
    return replace(blank, **json.loads(answer.read_text()), seconds=ended.seconds)
