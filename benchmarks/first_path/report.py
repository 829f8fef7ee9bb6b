"""The rows of ``benchmarks first-path``, and the table of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.bench import aim_lines, closing_lines
from planner.base.tables import markdown_table, median, percentile
from planner.batch.outcomes import SOLVED
from planner.reproduce.report import Verdict, tally

OURS, OMPL = "planner", "OMPL RRTConnect, plain coal"
OTHERS = ("roboplan", "pyroboplan")


@dataclass(frozen=True)
class Row:
    """One problem by one method. Up to ``software``: what was asked; then the results, None where there are none.

    ``content``: a hash of the problem's files. Seconds of the wall clock: ``setup_s`` to load robot and obstacles,
    then ``first_s`` to a path and ``path_s`` to the path after shortcuts; ``cpu_s`` of the processor, all together,
    where it was measured. ``contacts``: segments on which the library that has not planned finds a contact when it
    looks at every millimetre of motion; ``message``: the first of them.
    """

    problem: str
    method: str
    seed: int
    robot: str
    collision: str
    seconds: float
    content: str
    software: str
    outcome: str
    message: str = ""
    version: str | None = None
    setup_s: float | None = None
    first_s: float | None = None
    path_s: float | None = None
    cpu_s: float | None = None
    length_rad: float | None = None
    corners: int | None = None
    contacts: int | None = None

    @property
    def key(self) -> tuple:
        """What was asked."""
        asked = self.seed, self.robot, self.collision, self.seconds, self.content, self.software
        return (self.problem, self.method, *asked)


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The report for people."""
    header = ["method", "solved", "of", "setup (s)", "first path (s)", "after shortcuts (s)", "95 % (s)", "CPU (s)"]
    header += ["length (rad)", "corners", "paths touching", "proven"]
    lines = [_cells(method, _of(rows, method)) for method in dict.fromkeys(row.method for row in rows)]
    text = ["# python -m benchmarks first-path", "", *markdown_table(header, lines), "", *aim_lines(aims(rows)), ""]
    text += [f"- {row.problem}, {row.method}: {row.outcome}. {row.message}" for row in rows if row.outcome != SOLVED]
    text += [f"- {row.problem}, {row.method} touches: {row.message}." for row in rows if row.contacts]
    return "\n".join([*text, *closing_lines(rows, complete, "runs", _METHOD)]) + "\n"


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What is meant to hold; of 0 where nothing was measured."""
    ours = [row for row in _of(rows, OURS) if row.outcome == SOLVED]
    first = median(row.first_s for row in ours)
    return (
        tally("No path of ours touches anything.", (row.contacts == 0 for row in ours), ""),
        tally(
            "Our first proven path is there within 0.08 s in the median, once robot and scene are loaded.",
            [] if first is None else [first <= 0.08],
            "" if first is None else f"{first:.3f} s",
        ),
    )


def _of(rows: Sequence[Row], method: str) -> list[Row]:
    return [row for row in rows if row.method == method]


def _cells(method: str, rows: Sequence[Row]) -> list[Any]:
    """A line of medians over the solved problems."""
    solved = [row for row in rows if row.outcome == SOLVED]
    version = next((f" {row.version}" for row in solved if row.version), "")
    medians = [median(getattr(row, name) for row in solved) for name in ("setup_s", "first_s", "path_s")]
    rest = [median(getattr(row, name) for row in solved) for name in ("cpu_s", "length_rad", "corners")]
    touching = f"{sum(bool(row.contacts) for row in solved)} of {len(solved)}"
    late = percentile((row.path_s for row in solved), 95.0)
    proven = "every motion" if method == OURS else "none"
    return [method + version, len(solved), len(rows), *medians, late, *rest, touching, proven]


_METHOD = """How. Every run has a process of its own, one after the other; libraries are loaded before the clocks start.
Times are medians over the problems that the method solved, of the wall clock; shortcuts count from the same moment as
the first path. Ours: `planner plan --path-only` without motion and page, every motion proven. OMPL: RRTConnect and
`simplifyMax` with its defaults, a Python callback that asks Pinocchio and coal about all pairs. roboplan (C++) and
pyroboplan (Python): RRT-Connect and their own shortcuts, states 0.05 rad apart, in the environments given by
`--python NAME=PATH`, with the same URDF, limits, link pairs and obstacles; roboplan's connection distance is its
default, 3 rad, pyroboplan's 1 rad. Of several goals the others get the first. Touching: the collision library that we
have not planned with looks at every millimetre of motion. Limitations. The others stop by the clock: on a loaded
machine they solve fewer problems. Only boxes, spheres and cylinders can be told to all. A path that is not proven
can touch less, or more, than this look sees."""
