"""``planner sweep --seeds``: the same trade-off on the roadmaps of several seeds, a row and a folder each."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from planner.base.errors import OptionError
from planner.base.files import is_file, make_folder
from planner.base.progress import QUIET, Progress
from planner.base.tables import markdown_table
from planner.batch.results import Results, ResultsFile, measure_missing
from planner.batch.tasks import request_hash
from planner.problem.outcome import Outcome
from planner.problem.request import SERIAL, SweepRequest, WorkersRequest
from planner.processes.source import software
from planner.tradeoff.nondominated import MAX_LABELS
from planner.tradeoff.record import JSON_NAME, save_sweep
from planner.tradeoff.sweep import Tradeoff, sweep

CSV_NAME = "seeds.csv"
_SHOWN = (
    "seed",
    "outcome",
    "intervals",
    "manipulability_cost",
    "distance_cost",
    "w_min",
    "w_mean",
    "length_rad",
    "nodes",
)


@dataclass(frozen=True)
class Row:
    """One seed; ``asked`` is a hash of the options and of all files that are read, and how far a front is searched for.

    ``manipulability_cost``, ``w_min`` and ``w_mean`` are those of the path at beta 0, ``distance_cost`` and
    ``length_rad`` those of the path at beta 1; None where there is no path.
    """

    seed: int
    asked: str
    software: str
    outcome: str
    intervals: int
    manipulability_cost: float | None
    distance_cost: float | None
    w_min: float | None
    w_mean: float | None
    length_rad: float | None
    nodes: int
    edges: int
    solves: int
    roadmap_sha256: str
    seconds: float


def sweep_seeds(
    request: SweepRequest,
    seeds: Sequence[int],
    out: Path,
    front: bool = False,
    max_labels: int = MAX_LABELS,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> Results[Row]:
    """One sweep per seed into ``out``/seed-K, and a row each in ``seeds.csv``.

    Rows of the same options, files and software whose folder is there are kept; of others the folder is taken, and so
    the row. A sweep that is interrupted is left out, and begun anew by the next run. Raises :class:`PlannerError` for
    unusable input.
    """
    if not seeds or len(set(seeds)) < len(seeds):
        raise OptionError("give at least one seed, and each only once.")
    requests = [replace(request, seed=seed) for seed in seeds]
    make_folder(out)
    ledger = ResultsFile(out / CSV_NAME, Row, "planner sweep --seeds", lambda row: row.seed, lambda row: row.seed)
    here, labels = software(), max_labels if front else 0

    def cached(one: SweepRequest) -> list[Row]:
        kept = ledger.find(one.seed) if is_file(_folder(out, one) / JSON_NAME) else []
        return [row for row in kept if (row.asked, row.software) == (_asked(one, labels), here)]

    measure = partial(_measure, out=out.absolute(), labels=labels)
    rows, complete = measure_missing(ledger, requests, cached, measure, "seeds", progress, workers)
    return Results(tuple(rows), _to_markdown(rows, complete, out), complete)


def _folder(out: Path, request: SweepRequest) -> Path:
    return out / f"seed-{request.seed}"


def _asked(request: SweepRequest, labels: int) -> str:
    """A hash of what is asked for, and the ``labels`` that the search of a front may make, 0 without one."""
    return request_hash(request) + (f"-front-{labels}" if labels else "")


def _measure(request: SweepRequest, progress: Progress, out: Path, labels: int) -> list[Row]:
    """The row of one seed; none where stopped."""
    begin, asked = time.perf_counter(), _asked(request, labels)  # files may change while it is measured
    found = sweep(request, progress.renamed(lambda stage, done, total: None), labels > 0, labels or MAX_LABELS)
    if found.outcome is Outcome.INTERRUPTED:
        return []
    save_sweep(found, _folder(out, request))
    return [_row(found, asked, time.perf_counter() - begin)]


def _row(found: Tradeoff, asked: str, seconds: float) -> Row:
    first, last = (found.intervals[0], found.intervals[-1]) if found.intervals else (None, None)
    return Row(
        seed=found.request.seed,
        asked=asked,
        software=software(),
        outcome=found.outcome.key,
        intervals=len(found.intervals),
        manipulability_cost=first and first.manipulability_cost,
        distance_cost=last and last.distance_cost,
        w_min=first and first.w_min,
        w_mean=first and first.w_mean,
        length_rad=last and last.joint_length,
        nodes=len(found.roadmap.nodes),
        edges=len(found.roadmap.edges),
        solves=found.solves,
        roadmap_sha256=found.roadmap.sha256,
        seconds=seconds,
    )


def _to_markdown(rows: Sequence[Row], complete: bool, out: Path) -> str:
    lines = markdown_table(_SHOWN, ([getattr(row, name) for name in _SHOWN] for row in rows), 0)
    ending = [] if complete else ["", "Interrupted: the same command goes on from here."]
    return "\n".join([*lines, *ending, "", f"Rows: {out / CSV_NAME}, folders: {out}/seed-K."])
