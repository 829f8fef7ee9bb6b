"""The rows of ``benchmarks tables``, and the tables of them beside the published numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.bench import aim_lines, closing_lines
from benchmarks.tables.published import GCS, GCS_TASKS, MBM, MISSING, PUBLISHED, SOURCES, Published
from planner.base.tables import markdown_table, median
from planner.batch.outcomes import SOLVED
from reproduce.verdict import Verdict, tally


@dataclass(frozen=True)
class Row:
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
    outcome: str
    message: str = ""
    seconds: float | None = None
    cpu_s: float | None = None
    built_s: float | None = None
    length_rad: float | None = None
    straight_rad: float | None = None
    w_min: float | None = None
    w_mean: float | None = None
    contacts: int | None = None

    @property
    def key(self) -> tuple:
        """What was asked."""
        asked = self.nodes, self.seed, self.collision, self.content, self.software
        return (self.table, self.task, self.method, *asked)


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The report for people."""
    lines = ["# python -m benchmarks tables", "", "Published numbers are typed off, ours are measured.", ""]
    of = {table: [row for row in rows if row.table == table] for table in (GCS, MBM)}
    if of[GCS]:
        lines += ["## Five tasks of the iiwa 14", "", *_task_tables(of[GCS]), "", _source(GCS), ""]
    if of[MBM]:
        lines += ["## MotionBenchMaker's problems for the Panda", "", *_summary_table(of[MBM]), "", _source(MBM), ""]
    lines += [*aim_lines(aims(rows)), *_failures(rows), "", "## What could not be had", ""]
    lines += [f"- {text}" for text in MISSING]
    return "\n".join([*lines, *closing_lines(rows, complete, "runs", _METHOD)]) + "\n"


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What ours is meant to hold; nothing is claimed of others' numbers."""
    tried = [row for row in rows if not row.message]
    solved = [row for row in rows if row.outcome == SOLVED]
    return (
        tally("Every task is solved.", (row.outcome == SOLVED for row in tried), ""),
        tally("No contact is found on a path of ours.", (row.contacts == 0 for row in solved), ""),
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
    """Medians over the folder's problems, and the published ones over theirs."""
    header = ["method", "solved", "of", "length (rad)", "seconds", "CPU (s)", "w, least", "w, mean", "paths touching"]
    lines: list[list[Any]] = [
        [f"{one.method}, published", 699, 700, one.length_rad, one.seconds, None, None, None, None]
        for one in PUBLISHED
        if one.table == MBM
    ]
    for method in dict.fromkeys(row.method for row in rows):
        of = [row for row in rows if row.method == method]
        solved = [row for row in of if row.outcome == SOLVED]
        columns = ("length_rad", "seconds", "cpu_s", "w_min", "w_mean")
        medians = [median(getattr(row, name) for row in solved) for name in columns]
        lines.append([f"ours, {method}, median", len(solved), len(of), *medians, sum(bool(r.contacts) for r in solved)])
    return markdown_table(header, lines)


def _published(theirs: Sequence[Published], task: str, method: str, column: str) -> float | None:
    return next((getattr(one, column) for one in theirs if (one.task, one.method) == (task, method)), None)


def _failures(rows: Sequence[Row]) -> list[str]:
    return [f"- {row.task}, {row.method}: {row.outcome}. {row.message}" for row in rows if row.outcome != SOLVED]


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _source(table: str) -> str:
    return f"Source. {SOURCES[table]}"


_METHOD = """How ours is measured. Every method has a process of its own; seconds are of the wall clock, once libraries,
robot and scene are loaded; a machine with other work beside is slower, so the processor's seconds are in tables.csv.
"path only" is `planner plan --path-only`, "beta 1" and the others `planner plan` with that beta and `--nodes`, without
motion and page; "kept roadmap" is a query at beta 1 on a roadmap of `--nodes` nodes that was grown around the scene's
home configuration and knows none of the tasks. Every motion of ours is proven. Published numbers are of other machines,
models and work: they stand here so that ours can be judged, not as a race."""
