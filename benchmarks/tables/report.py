"""The rows of ``benchmarks tables``, and the tables of them with the published numbers.

Columns. A row is one task by one of our methods.

``seconds`` of the wall clock and ``cpu_s`` of the processor count from the loaded robot and scene; ``build_s`` is the
time of the saved roadmap, which they leave out. ``contacts``: segments on which the library that has not planned finds
a contact at a millimetre of motion.
"""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks import bench
from benchmarks.tables.published import GCS_TASKS, LENGTHS_RAD, SECONDS, SOURCE
from benchmarks.text import markdown_table
from planner.batch.run import SOLVED


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """Return tables of length, seconds and manipulability, a line per task, with the published columns first."""
    lines = ["Published numbers are copied, ours are measured.", "", "## Five tasks of the iiwa 14", ""]
    lines += _columns("length (rad)", rows, "length_rad", LENGTHS_RAD)
    lines += _columns("seconds", rows, "seconds", SECONDS)
    lines += [f"- The saved roadmap took {row.build_s:.3g} s more." for row in rows if row.build_s is not None][:1]
    lines += ["", *_columns("w, least", rows, "w_min"), *_columns("w, mean", rows, "w_mean"), f"Source. {SOURCE}", ""]
    return lines


def _columns(
    title: str, rows: Sequence[bench.Row], name: str, published: dict[str, tuple[float, ...]] | None = None
) -> list[str]:
    """Return a table of one column of the rows: a line per task, a cell per published method and per method of ours."""
    methods, theirs = list(dict.fromkeys(row.method for row in rows)), published or {}
    values = {(row.task, row.method): getattr(row, name) for row in rows}
    straight = {row.task: row.straight_rad for row in rows if row.straight_rad}
    header = [title, *(f"{method}, published" for method in theirs), *(f"ours, {method}" for method in methods)]
    lines = []
    for k, ends in enumerate(GCS_TASKS):
        task = " to ".join(ends)
        lines.append([task, *(each[k] for each in theirs.values()), *(values.get((task, m)) for m in methods)])
        lines[-1] += [straight.get(task)] if name == "length_rad" else []
    return [*markdown_table([*header, *(["straight line"] if name == "length_rad" else [])], lines), ""]


def fault(row: bench.Row) -> str:
    """Return the outcome of a task that is not solved, else an empty text."""
    return "" if row.outcome == SOLVED else f"{row.task}, {row.method}: {row.outcome}. {row.message or ''}"


def aims(rows: Sequence[bench.Row]) -> tuple[bench.Verdict, ...]:
    """Return the verdicts on our own rows."""
    solved = [row for row in rows if row.outcome == SOLVED]
    return (
        bench.tally("Every task is solved.", (row.outcome == SOLVED for row in rows), ""),
        bench.tally("No contact is found on a path of ours.", (row.contacts == 0 for row in solved), ""),
    )
