"""The rows of ``benchmarks optimum``, and what they add up to: gaps to the optimum, falling with effort."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.bench import aim_lines, closing_lines
from planner.base.tables import markdown_table, median, percentile
from reproduce.verdict import Verdict, tally

_AIMS = {1000: 1.0, 5000: 0.3}  # %: the gap that is aimed at for planar_2r, by the number of nodes


@dataclass(frozen=True)
class Row:
    """One plan. ``cost`` and ``optimum``: finely integrated, of its path and of the grid's; ``gap``: in %. ``error``
    (%): what the grid's last halving changed.

    ``curve``: gaps (%) after each round of the effort, with blanks between, as plan.json's curve has them.
    """

    arm: str
    beta: float
    nodes: int
    effort: int
    seed: int
    software: str
    cost: float
    optimum: float
    error: float
    gap: float
    corners: int
    curve: str

    @property
    def key(self) -> tuple:
        """What was asked."""
        return (self.arm, self.beta, self.nodes, self.effort, self.seed, self.software)


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The report for people."""
    header = [
        "arm",
        "beta",
        "nodes",
        "effort",
        "plans",
        "optimum",
        "its error (%)",
        "gap (%)",
        "largest (%)",
        "corners",
        "gap falls as",
    ]
    cases = dict.fromkeys((row.arm, row.beta, row.nodes, row.effort) for row in rows)
    lines = []
    for case in cases:
        some = [row for row in rows if (row.arm, row.beta, row.nodes, row.effort) == case]
        gaps = [row.gap for row in some]
        fit = fitted_power(some)
        falls = "-" if fit is None else f"{fit[0]:.2g} % / rounds^{fit[1]:.2f}"
        best, error = median(row.optimum for row in some), max(row.error for row in some)
        gap = [median(gaps), percentile(gaps, 100), median(row.corners for row in some)]
        lines.append([*case, len(some), best, error, *gap, falls])
    text = ["# python -m benchmarks optimum", "", *markdown_table(header, lines), "", *aim_lines(aims(rows))]
    return "\n".join([*text, *closing_lines(rows, complete, "plans", _METHOD)]) + "\n"


def fitted_power(rows: Sequence[Row]) -> tuple[float, float] | None:
    """(c, p) of gap = c rounds^-p, fitted to the logarithms of the median gaps; None for fewer than four rounds."""
    curves = [[float(gap) for gap in row.curve.split()] for row in rows]
    length = min((len(curve) for curve in curves), default=0)
    points = [(k, float(np.median([curve[k] for curve in curves]))) for k in range(1, length)]
    points = [(math.log(k), math.log(gap)) for k, gap in points if gap > 0]
    if len(points) < 4:
        return None
    x, y = np.array(points).T
    slope, level = np.polyfit(x, y, 1)
    return math.exp(level), -float(slope)


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What plans for planar_2r are meant to reach."""
    found = []
    for nodes, limit in _AIMS.items():
        gaps = [row.gap for row in rows if row.arm == "planar_2r" and row.nodes == nodes]
        sentence = f"planar_2r with {nodes} nodes is within {limit:g} % of the optimum."
        found.append(tally(sentence, [gap <= limit for gap in gaps], "" if not gaps else f"At most {max(gaps):.2g} %."))
    return tuple(found)


_METHOD = """How. Each arm is planar, its geometry and its w are computed anew in the plane, without the planner's
checker and kinematics. The optimum is the cheapest path over a grid of configurations whose edges are proven free,
halved in a tube around that path and then pulled tight; with omega scaled as the plan's roadmap scales it. Its error is
what the last halving changed. A gap below 0 says that the plan is better than the grid's path. The fit is over the
rounds of the effort, to median gaps."""
