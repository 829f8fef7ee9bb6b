"""The rows of ``benchmarks tool-paths``, and what they add up to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.bench import aim_lines, closing_lines
from planner.base.tables import markdown_table, median, percentile
from reproduce.verdict import Verdict, tally

_FIRST, _AGAIN = 1.0, 0.05  # s that are aimed at for a raster of 200 points
_BESIDE = ("position", "angle", "contacts", "w_min", "duration")
_OPTIMUM = 1.05  # of toppra's duration


@dataclass(frozen=True)
class Row:
    """One path. ``followed``: share of it, and by a ladder of four times as many solutions; ``position`` and ``angle``:
    the largest deviations that the judge saw, as shares of the tube; ``jump``: largest step of a joint between two
    looks (rad); seconds of CPU from nothing without a motion, with another beta, and for the same again with a motion.
    ``toppra_s``: how long toppra takes along the same curve; then what roboplan's Cartesian planner makes of the path.
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
    toppra_s: float | None = None
    roboplan_followed: float | None = None
    roboplan_position: float | None = None
    roboplan_angle: float | None = None
    roboplan_contacts: int | None = None
    roboplan_w_min: float | None = None
    roboplan_duration: float | None = None

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
    rows_of = [row for row in rows if row.roboplan_followed is not None]
    beside = _beside_roboplan(rows_of) if rows_of else []
    text = ["# python -m benchmarks tool-paths", "", *markdown_table(header, lines), "", *aim_lines(aims(rows))]
    return "\n".join([*text, *beside, *closing_lines(rows, complete, "paths", _METHOD)]) + "\n"


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
        tally(
            f"A motion takes {_OPTIMUM:g} of the time that toppra takes along the same curve.",
            [row.duration <= _OPTIMUM * row.toppra_s for row in rows if row.toppra_s],
            "where toppra is installed",
        ),
        tally(f"Another beta takes {_AGAIN:g} s.", [row.again_s <= _AGAIN for row in rasters], ""),
    )


def _beside_roboplan(rows: Sequence[Row]) -> list[str]:
    """Shares followed, deviations, smallest w and durations, ours and roboplan's."""
    header = ["software", "share followed, mean", "whole", "deviation / tube", "contacts", "w, median", "s, median"]
    shares = [row.followed for row in rows], [row.roboplan_followed or 0.0 for row in rows]
    both = [row for k, row in enumerate(rows) if min(of[k] for of in shares) >= 1.0 - 1e-9]
    lines = []
    for name, prefix, of in zip(("ours", "roboplan"), ("", "roboplan_"), shares, strict=True):
        found = {key: [getattr(row, prefix + key) or 0.0 for row in both] for key in _BESIDE}
        off = max([*found["position"], *found["angle"]], default=0.0)
        middle = [median(found[key]) if both else 0.0 for key in ("w_min", "duration")]
        whole = sum(share >= 1.0 - 1e-9 for share in of)
        lines.append([name, sum(of) / len(of), whole, off, int(sum(found["contacts"])), *middle])
    said = "Beside roboplan's Cartesian planner on the same paths; from the third number on where both follow all:"
    return ["", said, "", *markdown_table(header, lines)]


_METHOD = """How. Each path lies across the tool's axis around where that is in a random free configuration; the tool
may turn about its axis; for roboplan it keeps the turn with which ours begins, and begins there. The judge
looks at the motion in time every 0.05 mm of the tool's way, with Pinocchio's frames; coal looks every 0.5 mm.
Rasters have 200 points. Seconds are of CPU, first to motion."""
