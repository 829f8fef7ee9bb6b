"""Benchmark logs as OMPL's tools write them, for ``ompl_benchmark_statistics`` and Planner Arena.

The format is that of OMPL's documentation, "How to Benchmark Planners", section on the log file: one experiment a file,
here a problem; a planner is one settings; a run is one seed.
"""

from __future__ import annotations

import importlib.metadata
import platform
import re
from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from benchmarks.plan.rows import Row, by_settings
from planner.base.files import make_folder, write_whole
from planner.batch.outcomes import CRASHED, NO_PATH, REFUSED, SOLVED, TIMED_OUT

_STATUS = ("Unknown status", "Invalid start", "Invalid goal", "Unrecognized goal type", "Timeout")
_STATUS += ("Approximate solution", "Exact solution", "Crash", "Abort")
_STATUS_OF = {SOLVED: 6, NO_PATH: 4, TIMED_OUT: 4, REFUSED: 1, CRASHED: 7}

_PROPERTIES: dict[str, Callable[[Row], Any]] = {
    "status ENUM": lambda row: _STATUS_OF.get(row.outcome, 0),
    "time REAL": lambda row: row.total_s if row.total_s is not None else row.process_s,
    "memory REAL": lambda row: row.memory_mib,
    "solved BOOLEAN": lambda row: row.outcome == SOLVED,
    "approximate solution BOOLEAN": lambda row: False,
    "correct solution BOOLEAN": lambda row: None if row.contacts is None else row.contacts == 0,
    "solution length REAL": lambda row: row.length_rad,
    "solution clearance REAL": lambda row: row.clearance_m,
    "solution segments INTEGER": lambda row: None if row.waypoints is None else row.waypoints - 1,
    "graph states INTEGER": lambda row: row.nodes,
    "graph motions INTEGER": lambda row: row.edges,
    "certified motions INTEGER": lambda row: row.certified,
    "first path time REAL": lambda row: row.first_path_s,
    "tool path length REAL": lambda row: row.length_m,
    "least manipulability REAL": lambda row: row.w_min,
    "mean manipulability REAL": lambda row: row.w_mean,
    "seed INTEGER": lambda row: row.seed,
}


def write_logs(rows: Iterable[Row], folder: Path) -> list[Path]:
    """One log a problem under ``folder``, made if need be; returns their paths."""
    make_folder(folder)
    problems: dict[str, list[Row]] = {}
    for row in rows:
        problems.setdefault(row.problem, []).append(row)
    paths = []
    for problem, of in sorted(problems.items()):
        path = folder / f"{_word(problem)}.log"
        write_whole(path, to_log(problem, of).encode())
        paths.append(path)
    return paths


def to_log(problem: str, rows: Sequence[Row]) -> str:
    """The log of one problem."""
    planners = by_settings(rows)
    most = max(map(len, planners.values()))
    lines = [
        f"gabf-planner version {importlib.metadata.version('gabf-planner')}",
        f"Experiment {_word(problem)}",
        f"Running on {_word(platform.node()) or 'unknown'}",
        f"Starting at {datetime.now(UTC):%Y-%m-%d %H:%M:%S}",
        "<<<|",
        f"problem {problem}, files {rows[0].content}",
        rows[0].software,
        "|>>>",
        f"{min(row.seed for row in rows)} is the random seed",
        f"{max(row.time_limit_s for row in rows):g} seconds per run",
        "inf MB per run",
        f"{most} runs per planner",
        f"{sum(row.process_s or 0.0 for row in rows):.6f} seconds spent to collect the data",
        "1 enum type",
        "|".join(("status", *_STATUS)),
        f"{len(planners)} planners",
    ]
    for label, of in planners.items():
        lines += _planner(label, of)
    return "\n".join(lines) + "\n"


def _planner(label: str, rows: Sequence[Row]) -> list[str]:
    first = rows[0]
    common = {"robot": first.robot, "collision": first.collision, "nodes": first.nodes_asked, "beta": first.beta}
    common |= {"widen limits": int(first.widen_limits), "options": first.options or "none"}
    runs = ["".join(f"{_text(read(row))}; " for read in _PROPERTIES.values()) for row in rows]
    return [
        f"gabf ({label})",
        f"{len(common)} common properties",
        *(f"{name} = {value}" for name, value in common.items()),
        f"{len(_PROPERTIES)} properties for each run",
        *_PROPERTIES,
        f"{len(runs)} runs",
        *runs,
        ".",
    ]


def _text(value: Any) -> str:
    if value is None:
        return ""
    return str(int(value)) if isinstance(value, bool) else repr(value)


def _word(text: str) -> str:
    """Without spaces and slashes: the format ends a name at the first space."""
    return re.sub(r"[^\w.+-]+", "_", text)
