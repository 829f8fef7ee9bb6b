"""``planner batch``: a row and a folder for each plan; a repeated command reuses the rows.

The plans are in a YAML or CSV file, or in a folder of MoveIt's scenes and motion plan requests.
"""

import csv
import glob
import hashlib
import io
import json
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from planner.base.errors import FileError, OptionError, PlannerError
from planner.base.files import make_folder, write_json, write_whole
from planner.base.interrupts import stop_requests
from planner.base.progress import QUIET, Progress
from planner.base.resources import software
from planner.base.yamlfile import find_duplicates, parse_yaml, read_text
from planner.batch.parallel import measure_cases
from planner.planning.plan import plan
from planner.problem.request import SERIAL, PlanRequest, WorkersRequest
from planner.query.robots import sources_hash
from planner.tradeoff.sweep import add_alternatives

SOLVED, NO_PATH, REFUSED, TIMED_OUT, CRASHED = "solved", "no_path", "refused", "timed out", "crashed"
CSV_NAME, ROW_NAME = "batch.csv", "row.json"
Row: TypeAlias = dict[str, Any]
_ASKED = ("robot", "scene", "start", "goal", "beta", "seed")
_RESULTS = ("goal_reached", "waypoints", "cost", "w_min", "w_mean", "length_rad", "length_m")
_RESULTS += ("nodes", "edges", "edges_certified", "roadmap_sha256")
_SHOWN = 20  # plans without a path that the report names
_FILES = ("robot", "scene", "srdf", "motion_plan_request", "roadmap")  # options that may be the path of a file


@dataclass(frozen=True)
class Task:
    """One plan of a batch."""

    name: str
    request: PlanRequest

    @property
    def asked(self) -> Row:
        """The first columns of its row, with a hash of the options and of all files that are read for them."""
        config = self.request.config()
        read = json.dumps([config, sources_hash(self.request)], sort_keys=True)
        known = {"name": self.name, "asked": hashlib.sha256(read.encode()).hexdigest()[:16], "software": software()}
        return known | {name: value for name, value in config.items() if name in _ASKED}


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
    """Plan all that ``source`` asks for (:func:`read_plans`).

    Each plan has the folder ``out``/NAME, with ``plan.json``, ``roadmap.npz``, ``plan.html`` if ``pages``, and
    ``row.json``; ``batch.csv`` holds all rows. A row of the same options, files and software is kept, unless its plan
    crashed or ran out of time (s). A plan whose worker dies twice has crashed.
    """
    if not time_limit > 0:
        raise OptionError(f"time limit must be above 0 s, got {time_limit:g}.")
    tasks = read_plans(source, plain)
    rows = {task.name: row for task in tasks if (row := _load_row(task, out)) is not None}
    missing = [task for task in tasks if task.name not in rows]
    progress("plans", len(rows), len(tasks))
    measure = partial(_measure_row, out=out.absolute(), pages=pages, time_limit=time_limit)
    for k, row in measure_cases(missing, measure, workers, progress):
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
    return BatchResult(found, _report(found, len(tasks), out), len(found) == len(tasks))


def _report(rows: Sequence[Row], asked: int, out: Path) -> str:
    others = [f"{row['name']}: {row['outcome']}. {row['message']}" for row in rows if row["outcome"] != SOLVED]
    lines = [f"{len(rows) - len(others)} of {asked} solved. Rows: {out / CSV_NAME}, folders: {out}/NAME."]
    if len(rows) < asked:
        lines.append(f"Interrupted: {asked - len(rows)} were not planned; the same command goes on from here.")
    more = [f"and {len(others) - _SHOWN} more."] if len(others) > _SHOWN else []
    return "\n".join([*lines, *others[:_SHOWN], *more, ""])


def _load_row(task: Task, out: Path) -> Row | None:
    """Return the row in the plan's folder if options, files and software are the same; else None."""
    try:
        row = json.loads((out / task.name / ROW_NAME).read_text())
        same = row.items() >= task.asked.items()
    except (OSError, ValueError, AttributeError):  # missing, or damaged
        return None
    return row if same and row["outcome"] not in (CRASHED, TIMED_OUT) else None


def _write_row(task: Task, out: Path, results: Row) -> Row:
    blank = {"outcome": CRASHED, "message": "", **dict.fromkeys((*_RESULTS, "seconds"))}
    row = task.asked | blank | results
    make_folder(out / task.name)
    write_json(out / task.name / ROW_NAME, row)
    return row


def _measure_row(task: Task, progress: Progress, out: Path, pages: bool, time_limit: float) -> Row | None:
    """Plan and write the folder; None if ``progress`` was stopped before the end."""
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
        why = f"stopped after {time_limit:g} s; raise --time-limit, lower --nodes."
        results = {"outcome": TIMED_OUT, "message": why}
    return _write_row(task, out, results | {"seconds": time.perf_counter() - begin})


def _plan(request: PlanRequest, progress: Progress, folder: Path, pages: bool) -> Row:
    """Return the results of a plan, a refusal or a crash; write its folder unless it was stopped."""
    try:
        found = plan(request=request, timing=None, progress=progress)
        if progress.stopped:
            return {}
        if pages:
            found = add_alternatives(found)
            found.save(folder)
        else:
            found.save_without_page(folder)
    except PlannerError as error:
        return {"outcome": REFUSED, "message": str(error)}
    except Exception as error:
        return {"message": f"{type(error).__name__}: {error}"}
    record, roadmap = found.record, found.record.roadmap
    return {
        **{"outcome": record.outcome, "message": record.message},
        **{"goal_reached": record.goal, "waypoints": len(record.path) or None},
        "cost": getattr(record.cost, "total", None),
        "w_min": getattr(record.manipulability, "min", None),
        "w_mean": getattr(record.manipulability, "mean", None),
        "length_rad": getattr(record.path_length, "joint", None),
        "length_m": getattr(record.path_length, "workspace", None),
        **{"nodes": roadmap.nodes, "edges": roadmap.edges, "edges_certified": roadmap.edges_certified},
        "roadmap_sha256": roadmap.sha256,
    }


def read_plans(source: Path, plain: PlanRequest) -> list[Task]:
    """The plans of ``source``; an option that a plan leaves out is that of ``plain``.

    A folder, or folders in it, hold MoveIt's problems as MotionBenchMaker lays them out: ``request<X>.yaml`` with
    ``scene<X>.yaml`` (``.yml``, ``.scene``). A :class:`FileError` names the plan and the option.
    """
    where, beside = f"batch file {source}", source.parent
    if os.path.isdir(source):
        where, beside = f"folder {source}", source
        entries = _problems(source)
    elif source.suffix.lower() in (".yaml", ".yml"):
        data = parse_yaml(read_text(source, "batch file"), where)
        entries = data["plans"] if isinstance(data, dict) and [*data] == ["plans"] else None
        if not (isinstance(entries, list) and entries and all(isinstance(entry, dict) for entry in entries)):
            raise FileError(f"{where} must be a list of plans, as in plans: [{{name: left, scene: shelf}}].")
    elif source.suffix.lower() == ".csv":
        entries = _csv_entries(read_text(source, "batch file"), where)
    else:
        raise FileError(f"{where} must be a .yaml or .csv file, or a folder.")
    tasks = [_task(entry, k, plain, where, beside) for k, entry in enumerate(entries, start=1)]
    if twice := find_duplicates(task.name for task in tasks):
        raise FileError(f"{where} has two plans called '{twice[0]}': rename one.")
    return tasks


def _problems(folder: Path) -> list[dict[str, Any]]:
    """Return the entries of a folder, whose paths are relative to it; a missing scene is refused later."""
    entries = []
    for path in sorted(map(Path, glob.glob("**/request*.y*ml", root_dir=folder, recursive=True))):
        number = path.stem.removeprefix("request")
        scenes = [path.with_name(f"scene{number}{suffix}") for suffix in (".yaml", ".yml", ".scene")]
        scene = next((scene for scene in scenes if os.path.isfile(folder / scene)), scenes[0])
        kind = path.parent.as_posix() if path.parent.parts else folder.resolve().name
        entries.append({"name": f"{kind}/{number}", "scene": str(scene), "request": str(path)})
    if not entries:
        raise FileError(f"{folder} holds no problems: give a folder with request0001.yaml, scene0001.yaml and so on.")
    return entries


def _csv_entries(text: str, where: str) -> list[dict[str, Any]]:
    """An empty cell leaves its option out."""
    try:
        names, *rows = csv.reader(io.StringIO(text.removeprefix("\ufeff"), newline=""))  # Excel writes this mark
    except (csv.Error, ValueError):  # ValueError: the file is empty
        names, rows = [], []
    names, rows = [name.strip() for name in names], [row for row in rows if row]
    if not rows or find_duplicates(names) or any(len(row) != len(names) for row in rows):
        raise FileError(
            f"{where} must be a line of different option names and a line of as many cells for each plan: "
            "quote cells that hold a comma."
        )
    return [{name: cell.strip() for name, cell in zip(names, row, strict=True) if cell.strip()} for row in rows]


def _task(entry: Mapping[str, Any], number: int, plain: PlanRequest, where: str, beside: Path) -> Task:
    given = {key.replace("-", "_"): value for key, value in entry.items()}
    if "request" in given:  # as the command line spells it
        given["motion_plan_request"] = given.pop("request")
    name = str(given.pop("name", f"{number:04d}"))
    where = f"{where}, plan '{name:.100}'"
    if not Path(name).parts or Path(name).is_absolute() or ".." in Path(name).parts:
        raise FileError(f"{where}: its name must be that of a folder below --out.")
    for key, value in given.items():
        if key in _FILES and isinstance(value, str) and os.path.isfile(beside / value):
            given[key] = str(beside / value)
    try:
        return Task(name, plain.with_options(**given))
    except PlannerError as error:
        raise FileError(f"{where}: {error}") from None
