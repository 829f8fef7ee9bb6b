"""The rows of ``benchmarks tables``, and the tables of them beside the published numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks import bench
from benchmarks.tables.published import GCS, GCS_TASKS, MBM, MISSING, PUBLISHED, SOURCES, Published
from benchmarks.text import markdown_table
from planner.batch.run import CRASHED, SOLVED


@dataclass(frozen=True)
class Row(bench.Row):
    """One task by one of our methods. Up to ``software``: what was asked; then the results, None where there are none.

    ``seconds`` of the wall clock, ``cpu_s`` of the processor, once robot and scene are loaded; ``built_s``: to the
    roadmap that is kept, which is not part of them. ``contacts``: segments on which the library that has not planned
    finds a contact at a millimetre of motion.
    """

    table: str
    task: str
    method: str
    nodes: int
    seed: int
    collision: str
    content: str
    software: str
    outcome: str = CRASHED
    message: str = ""
    seconds: float | None = None
    cpu_s: float | None = None
    built_s: float | None = None
    length_rad: float | None = None
    straight_rad: float | None = None
    w_min: float | None = None
    w_mean: float | None = None
    contacts: int | None = None


def tables(rows: Sequence[Row]) -> list[str]:
    """Both collections of problems with their sources, and the problems that could not be had."""
    lines = ["Published numbers are typed off, ours are measured.", ""]
    of = {table: [row for row in rows if row.table == table] for table in (GCS, MBM)}
    if of[GCS]:
        lines += ["## Five tasks of the iiwa 14", "", *_task_tables(of[GCS]), "", _source(GCS), ""]
    if of[MBM]:
        lines += ["## MotionBenchMaker's problems for the Panda", "", *_summary_table(of[MBM]), _source(MBM), ""]
    return [*lines, "## What could not be had", "", *(f"- {text}" for text in MISSING), ""]


def fault(row: Row) -> str:
    """A task that is not solved."""
    return "" if row.outcome == SOLVED else f"{row.task}, {row.method}: {row.outcome}. {row.message}"


def aims(rows: Sequence[Row]) -> tuple[bench.Verdict, ...]:
    """What ours is meant to hold; nothing is claimed of others' numbers."""
    tried = [row for row in rows if not row.message]
    solved = [row for row in rows if row.outcome == SOLVED]
    return (
        bench.tally("Every task is solved.", (row.outcome == SOLVED for row in tried), ""),
        bench.tally("No contact is found on a path of ours.", (row.contacts == 0 for row in solved), ""),
    )


def _task_tables(rows: Sequence[Row]) -> list[str]:
    """Length, seconds and manipulability, a line for each task; published columns first."""
    theirs = [one for one in PUBLISHED if one.table == GCS]
    names = list(dict.fromkeys(one.method for one in theirs))
    ours = list(dict.fromkeys(row.method for row in rows))
    tasks = [f"{start} to {goal}" for start, goal in GCS_TASKS]
    found = {(row.task, row.method): row for row in rows}
    header = [*(f"{name}, published" for name in names), *(f"ours, {name}" for name in ours)]

    def line(task: str, column: str) -> list[Any]:
        typed = [_published(theirs, task, name, column) for name in names]
        return [task, *typed, *(getattr(found.get((task, name)), column, None) for name in ours)]

    def with_straight(task: str) -> list[Any]:
        straight = next((row.straight_rad for row in rows if row.task == task and row.straight_rad), None)
        return [*line(task, "length_rad"), straight]

    lengths = markdown_table(["length (rad)", *header, "straight line"], map(with_straight, tasks))
    seconds = markdown_table(["seconds", *header], [line(task, "seconds") for task in tasks])
    built = next((row.built_s for row in rows if row.built_s is not None), None)
    note = "" if built is None else f"The roadmap that is kept took {built:.3g} s more, once for all tasks."
    w = [
        [
            task,
            *(
                f"{_text(row.w_min)} / {_text(row.w_mean)}" if (row := found.get((task, name))) else "-"
                for name in ours
            ),
        ]
        for task in tasks
    ]
    conditioned = markdown_table(["w, least / mean", *(f"ours, {name}" for name in ours)], w)
    return [*lengths, "", *seconds, "", *([note, ""] if note else []), *conditioned]


def _summary_table(rows: Sequence[Row]) -> list[str]:
    """Published medians over their problems, and ours over the folder's."""
    header = ["method", "solved", "of", "length (rad)", "seconds"]
    theirs = [[one.method, 699, 700, one.length_rad, one.seconds] for one in PUBLISHED if one.table == MBM]
    names = {"length_rad": "length (rad)", "seconds": "seconds", "cpu_s": "CPU (s)"}
    names |= {"w_min": "w, least", "w_mean": "w, mean"}
    columns: dict[str, bench.Pick] = {"solved": bench.total(lambda row: row.outcome == SOLVED), "of": len}
    columns |= {header: bench.middle(name) for name, header in names.items()}
    columns |= {"paths touching": bench.total(lambda row: bool(row.contacts))}
    return [*markdown_table(header, theirs), "", "Ours, in the median:", "", *bench.table(rows, ["method"], columns)]


def _published(theirs: Sequence[Published], task: str, method: str, column: str) -> float | None:
    return next((getattr(one, column) for one in theirs if (one.task, one.method) == (task, method)), None)


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _source(table: str) -> str:
    return f"Source. {SOURCES[table]}"
