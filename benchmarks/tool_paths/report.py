"""The rows of ``benchmarks tool-paths``, and what they add up to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.bench import aim_lines, closing_lines
from planner.base.tables import markdown_table, median, percentile
from planner.reproduce.report import Verdict, tally

_FIRST, _AGAIN = 1.0, 0.05  # s that are aimed at for a raster of 200 points


@dataclass(frozen=True)
class Row:
    """One path. ``followed``: share of it, and by a ladder of four times as many solutions; ``position`` and ``angle``:
    the largest deviations that the judge saw, as shares of the tube; ``jump``: largest step of a joint between two
    waypoints (rad); seconds from nothing without a motion, with another beta, and for the same again with a motion.
    """

    robot: str
    scene: str
    kind: str
    seed: int
    software: str
    points: int
    followed: float
    denser: float
    proven: bool
    position: float
    angle: float
    contacts: int
    jump: float
    w_min: float
    duration: float
    first_s: float
    again_s: float
    motion_s: float
    outcome: str

    @property
    def key(self) -> tuple:
        """What was asked."""
        return (self.robot, self.scene, self.kind, self.seed, self.software)


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The report for people."""
    header = ["robot", "scene", "kind", "paths", "whole", "denser", "off / tube", "jump (rad)", "first (s)",
              "again (s)", "motion (s)"]  # fmt: skip
    lines = []
    for case in dict.fromkeys((row.robot, row.scene, row.kind) for row in rows):
        some = [row for row in rows if (row.robot, row.scene, row.kind) == case]
        whole, denser = (sum(share >= 1.0 - 1e-9 for share in shares) for shares in
                         ([row.followed for row in some], [row.denser for row in some]))  # fmt: skip
        off = max(max(row.position, row.angle) for row in some)
        seconds = [median(getattr(row, name) for row in some) for name in ("first_s", "again_s", "motion_s")]
        lines.append([*case, len(some), whole, denser, off, percentile([row.jump for row in some], 100), *seconds])
    text = ["# python -m benchmarks tool-paths", "", *markdown_table(header, lines), "", *aim_lines(aims(rows))]
    return "\n".join([*text, *closing_lines(rows, complete, "paths", _METHOD)]) + "\n"


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What is aimed at."""
    moved, whole = [row for row in rows if row.followed > 0], [row for row in rows if row.denser >= 1.0 - 1e-9]
    rasters = [row for row in rows if row.kind == "raster" and row.followed >= 1.0 - 1e-9]
    return (
        tally(
            "A path that four times the solutions follow is followed.", [row.followed >= 1 - 1e-9 for row in whole], ""
        ),
        tally("What is followed is proven.", [row.proven for row in moved], ""),
        tally("No look finds the tool outside the tube.", [max(row.position, row.angle) <= 1.0 for row in moved], ""),
        tally("coal finds no contact.", [row.contacts == 0 for row in moved], ""),
        tally(f"A raster is planned in {_FIRST:g} s.", [row.first_s <= _FIRST for row in rasters], ""),
        tally(f"Another beta takes {_AGAIN:g} s.", [row.again_s <= _AGAIN for row in rasters], ""),
    )


_METHOD = """How. Each path lies across the tool's axis around where that is in a random free configuration; the tool
may turn about its axis. The judge looks at the motion in time every 0.05 mm of the tool's way, with Pinocchio's frames;
coal looks every 0.5 mm. Rasters have 200 points."""
