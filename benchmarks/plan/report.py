"""What the rows of ``benchmarks plan`` add up to: a table by scene type for each settings, and settings compared."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any

from benchmarks.bench import aim_lines, closing_lines
from benchmarks.plan.rows import Row, by_settings, of_outcome
from planner.base.tables import markdown_table, median, percentile
from planner.batch.outcomes import CRASHED, NO_PATH, REFUSED, SOLVED, TIMED_OUT
from reproduce.verdict import Verdict, tally

GOAL_SECONDS = 10.0
_HEADER = ["scene type", "runs", "refused", "solved", "of those tried", "in 10 s", "timed out", "no path", "crashed"]
_HEADER += ["time (s)", "95 %", "first path (s)", "length (rad)", "tool (m)", "min w", "mean w", "clearance (mm)"]
_HEADER += ["least (mm)", "nodes", "edges", "certified", "contacts"]


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The report for people."""
    lines = ["# python -m benchmarks plan"]
    for label, of in by_settings(rows).items():
        lines += ["", f"## {label}", "", *_by_kind(of), ""]
        lines += [*aim_lines(aims(of)), *_failures(of)]
    limits = ", ".join(f"{limit:g} s" for limit in sorted({row.time_limit_s for row in rows}))
    lines += [*_comparison(rows), "", f"Time limit: {limits or 'none'}."]
    return "\n".join([*lines, *closing_lines(rows, complete, "runs", _METHOD)]) + "\n"


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What the planner is meant to show on these problems, and whether rows of one settings do."""
    tried = [row for row in rows if row.outcome != REFUSED]
    solved = of_outcome(rows, SOLVED)
    speed = [row for row in solved if row.collision == "coal" and row.nodes_asked >= 1000]
    first, total = (median(getattr(row, name) for row in speed) for name in ("first_path_s", "total_s"))
    return (
        tally(
            f"Every problem whose states are within limits and free is solved within {GOAL_SECONDS:g} s.",
            (_in_time(row) for row in tried),
            f"Refused besides: {len(rows) - len(tried)}.",
        ),
        tally("No contact is found on a returned path.", (row.contacts == 0 for row in solved), ""),
        tally("Every edge of the roadmap is certified.", (row.certified == row.edges for row in solved), ""),
        tally("With coal a first proven path is there in 0.5 s in the median.", _at_most(first, 0.5), _seconds(first)),
        tally(
            "With coal the path from 1000 proven nodes is there in 5 s in the median.",
            _at_most(total, 5.0),
            _seconds(total),
        ),
    )


def _in_time(row: Row) -> bool:
    return row.outcome == SOLVED and row.total_s is not None and row.total_s <= GOAL_SECONDS


def _at_most(value: float | None, limit: float) -> list[bool]:
    return [] if value is None else [value <= limit]


def _seconds(value: float | None) -> str:
    return "" if value is None else f"It takes {value:.3g} s."


def _by_kind(rows: Sequence[Row]) -> list[str]:
    kinds = dict.fromkeys(row.kind for row in rows)
    lines = [_cells(kind, [row for row in rows if row.kind == kind]) for kind in kinds]
    return markdown_table(_HEADER, [*lines, _cells("all", rows)])


def _cells(name: str, rows: Sequence[Row]) -> list[Any]:
    count: Callable[[str], int] = lambda outcome: len(of_outcome(rows, outcome))  # noqa: E731
    solved = of_outcome(rows, SOLVED)
    tried = len(rows) - count(REFUSED)
    middle: Callable[[str], float | None] = lambda column: median(getattr(row, column) for row in solved)  # noqa: E731
    clearances = [row.clearance_m for row in solved if row.clearance_m is not None]
    share = f"{100.0 * len(solved) / tried:.0f} %" if tried else "-"
    counts = [len(rows), count(REFUSED), len(solved), share, sum(map(_in_time, rows)), count(TIMED_OUT)]
    cells = [name, *counts, count(NO_PATH), count(CRASHED), middle("total_s")]
    cells += [percentile((row.total_s for row in solved), 95.0), middle("first_path_s")]
    cells += [middle(column) for column in ("length_rad", "length_m", "w_min", "w_mean")]
    cells += [1e3 * middle_ if (middle_ := median(clearances)) is not None else None]
    cells += [1e3 * min(clearances) if clearances else None]
    cells += [_whole(middle(column)) for column in ("nodes", "edges", "certified")]
    return [*cells, sum(row.contacts or 0 for row in solved)]


def _whole(value: float | None) -> int | None:
    return None if value is None else round(value)


def _failures(rows: Sequence[Row]) -> list[str]:
    """Every run that was not solved, and every contact, by name."""
    bad = [row for row in rows if row.outcome != SOLVED]
    lines = [f"- {row.problem}, seed {row.seed}: {row.outcome}: {row.message}" for row in bad]
    touching = [row for row in rows if row.contacts]
    lines += [f"- {row.problem}, seed {row.seed}: {row.contacts} segments touch; {row.contact}" for row in touching]
    return ["", *lines] if lines else []


def _comparison(rows: Sequence[Row]) -> list[str]:
    """Settings set side by side on the runs that both solved."""
    groups = sorted(by_settings(rows).items(), key=lambda group: _rank(group[1][0]))
    lines = [
        compare(one, first, two, second)
        for (one, first), (two, second) in itertools.combinations(groups, 2)
        if _comparable(first[0], second[0])
    ]
    if not lines:
        return []
    header = ["settings", "against", "both solved", "length", "tool", "min w", "mean w", "time", "only against"]
    return ["", "## Compared", "", *markdown_table([*header, "only settings"], lines, texts=2), "", _RATIOS]


def _rank(row: Row) -> tuple:
    """What is compared against comes first: length only, plain options, fewer nodes."""
    return row.robot, row.collision, row.widen_limits, row.nodes_asked, -row.beta, row.options


def _comparable(first: Row, second: Row) -> bool:
    """Settings that differ in one point, or in anything but the world and the size from length only, beta = 1."""
    differ = sum(a != b for a, b in zip(first.settings, second.settings, strict=True))
    same_size = (first.robot, first.collision, first.nodes_asked, first.widen_limits) == (
        (second.robot, second.collision, second.nodes_asked, second.widen_limits)
    )
    return differ == 1 or (same_size and first.beta == 1.0 and not first.options)


def compare(one: str, first: Sequence[Row], two: str, second: Sequence[Row]) -> list[Any]:
    """Medians, over the runs of the same problem and seed that both solved, of the second's value over the first's."""
    mine, other = ({(r.problem, r.seed): r for r in of_outcome(rows, SOLVED)} for rows in (first, second))
    both = [(mine[key], other[key]) for key in mine if key in other]
    ratios = [
        median(_ratio(getattr(b, column), getattr(a, column)) for a, b in both)
        for column in ("length_rad", "length_m", "w_min", "w_mean", "total_s")
    ]
    return [two, one, len(both), *ratios, len(mine) - len(both), len(other) - len(both)]


def _ratio(value: float | None, base: float | None) -> float | None:
    return None if value is None or not base else value / base


_RATIOS = """Ratios are medians, over the problems and seeds that both solved, of the value with the settings over that
with those they are set against."""

_METHOD = """How. Every run is `planner plan` with the scene and the request of the problem and one seed, in a process
of its own. Its budget is the plan's own, in nodes and motions; the time limit only kills a run that takes too long,
which is then recorded as timed out. "Of those tried" leaves out the refused, whose start or goal is out of limits or
in collision. Times are of the planning itself, without the start of Python (0.5 to 1 s) and without the measurements;
they, lengths, w and clearances are medians over the solved runs, "95 %" is the 95th percentile. "First path" is when
start and goal were first joined by proven edges, where the planner tells. Lengths: Euclidean joint motion, and the
tool's path. w is Yoshikawa's manipulability sampled along the whole path; clearance the smallest distance to anything
every centimetre of motion, by the library that planned. Contacts: segments of the returned paths on which the other
collision library finds a contact when they are sampled every millimetre of motion. Limitations. Times depend on the
machine and what else it does; compare them within one run. A run that is killed says nothing about how much longer it
would have taken."""
