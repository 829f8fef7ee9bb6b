"""The rows of ``benchmarks quality``, and what they add up to: each method beside RRTConnect on the same problem."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.bench import aim_lines, closing_lines
from planner.base.tables import markdown_table, median
from planner.batch.outcomes import SOLVED
from reproduce.verdict import Verdict, tally

BASE = "RRTConnect"


@dataclass(frozen=True)
class Row:
    """One problem by one method; results are None where there are none.

    ``settings``: what of a plan was asked for, empty for OMPL's planners. ``content``: a hash of the problem's files.
    ``cpu_s``: processor time of the planning; ``cost`` and ``lower_bound`` as plan.json has them; ``corners``: changes
    of direction; ``dips``: w falls below that of both ends on the way.
    """

    problem: str
    method: str
    settings: str
    seed: int
    collision: str
    seconds: float
    content: str
    software: str
    outcome: str
    message: str = ""
    cpu_s: float | None = None
    cost: float | None = None
    lower_bound: float | None = None
    length_rad: float | None = None
    straight_rad: float | None = None
    corners: int | None = None
    w_min: float | None = None
    w_mean: float | None = None
    dips: bool | None = None

    @property
    def key(self) -> tuple:
        """What was asked."""
        who = self.method, self.settings, self.seed, self.collision, self.seconds
        return (self.problem, *who, self.content, self.software)

    @property
    def label(self) -> str:
        """The method as people read it."""
        return f"{self.method} {self.settings}".strip()


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The report for people."""
    header = ["method", "solved", "of", "length (rad)", "over straight", "corners", "mean w", "dips (%)", "gap (%)"]
    header += ["time (s)", "length", "mean w", "min w", "time"]
    labels = dict.fromkeys(row.label for row in rows)
    lines = [_cells(label, [row for row in rows if row.label == label], rows) for label in labels]
    text = ["# python -m benchmarks quality", "", *markdown_table(header, lines), "", *aim_lines(aims(rows))]
    bad = [row for row in rows if row.outcome != SOLVED]
    text += ["", *(f"- {row.problem}, {row.label}: {row.outcome}: {row.message}" for row in bad)]
    return "\n".join([*text, *closing_lines(rows, complete, "runs", _METHOD)]) + "\n"


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What paths are meant to reach, each as the medians over problems have it."""
    straight = [row for row in _solved(rows) if "beta 1," in row.settings]
    conditioned = [row for row in _solved(rows) if "beta 0," in row.settings]
    length, turns = median(_ratios(straight, rows, "length_rad")), median(row.corners for row in straight)
    share = sum(bool(row.dips) for row in conditioned) / len(conditioned) if conditioned else None
    gain = median(_ratios(conditioned, rows, "w_mean"))
    return (
        tally("At beta 1 length is at most 0.97 of RRTConnect's, simplified.", _at_most(length, 0.97), _said(length)),
        tally("At beta 1 a path has at most 3 corners.", _at_most(turns, 3.0), _said(turns)),
        tally("At beta 0 mean w is at least 1.2 times as large.", [] if gain is None else [gain >= 1.2], _said(gain)),
        tally("At beta 0 w dips below both ends in at most 10 % of paths.", _at_most(share, 0.1), _said(share)),
    )


def _at_most(value: float | None, limit: float) -> list[bool]:
    return [] if value is None else [value <= limit]


def _said(value: float | None) -> str:
    return "" if value is None else f"It is {value:.3g}."


def _solved(rows: Sequence[Row]) -> list[Row]:
    return [row for row in rows if row.outcome == SOLVED]


def _ratios(rows: Sequence[Row], everything: Sequence[Row], column: str) -> list[float]:
    """The column's value over RRTConnect's on the same problem and seed, where both are solved."""
    base = {(row.problem, row.seed): getattr(row, column) for row in _solved(everything) if row.method == BASE}
    return [getattr(row, column) / value for row in rows if (value := base.get((row.problem, row.seed)))]


def _cells(label: str, rows: Sequence[Row], everything: Sequence[Row]) -> list[Any]:
    solved = _solved(rows)
    over = [row.length_rad / row.straight_rad for row in solved if row.length_rad and row.straight_rad]
    gaps = [100.0 * (row.cost / row.lower_bound - 1.0) for row in solved if row.cost and row.lower_bound]
    dips = 100.0 * sum(bool(row.dips) for row in solved) / len(solved) if solved else None
    cells = [label, len(solved), len(rows), median(row.length_rad for row in solved), median(over)]
    cells += [median(row.corners for row in solved), median(row.w_mean for row in solved), dips, median(gaps)]
    cells += [median(row.cpu_s for row in solved)]
    return [*cells, *(median(_ratios(solved, everything, name)) for name in ("length_rad", "w_mean", "w_min", "cpu_s"))]


_METHOD = """How. Every run has a process of its own; times are of its processor, without the loading of libraries.
OMPL's planners check motions in states between which no point moves further than 2 cm, with the library that plans,
and prove nothing; RRT* and BIT* minimise length and stop when their time is up, RRTConnect when it has a path, which
OMPL's simplification then shortens. Columns up to time are medians over the solved problems; the last four are medians
of ratios to RRTConnect's value on the same problem and seed. Corners are changes of direction. A path dips where its w
falls below that of both its ends. The gap is that of the cost to a lower bound that holds for every path: the straight
line, at the best omega there can be on all of it; below beta 1 most of the gap is the bound's."""
