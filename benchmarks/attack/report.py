"""The rows of ``benchmarks attack``, and the tables of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.attack.claims import ROUNDING
from benchmarks.bench import aim_lines, closing_lines
from planner.base.tables import markdown_table
from planner.collision import BACKENDS
from reproduce.verdict import Verdict, tally


@dataclass(frozen=True)
class Row:
    """One attack on one library: on two kinds of shapes, or on a robot (``second``: the kind of what stands before it).

    ``attack``: "claims" on distances of two shapes, "segments" that are called free, or "reach", the bound on motion.
    Metres: the largest claim minus truth of each call (``distances_m`` to ``verdict_m``; empty where the call claimed
    nothing), of the clearance of a free segment, of a motion minus its bound; ``beyond_m``: the largest of them minus
    what the contract allows; ``short_m``: the largest truth minus what ``distances`` says; ``open_m``: the widest
    doubt about a truth. ``apart``: cases that do not touch; ``free``: segments called free, ``false_free``: of these,
    with a contact. ``share``: the largest share of its bound that a motion takes. ``found``: the worst cases, as JSON.
    """

    attack: str
    first: str
    second: str
    library: str
    tries: int
    seed: int
    tried: int
    apart: int | None
    free: int | None
    false_free: int | None
    distances_m: float | None
    coarse_m: float | None
    close_m: float | None
    verdict_m: float | None
    clearance_m: float | None
    reach_m: float | None
    share: float | None
    beyond_m: float | None
    short_m: float | None
    open_m: float | None
    found: str
    software: str

    @property
    def key(self) -> tuple:
        """What was asked."""
        return self.attack, self.first, self.second, self.library, self.tries, self.seed, self.software


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What has to hold, and whether it did; of 0 where that was not attacked."""
    claims, segments, reach = (
        [row for row in rows if row.attack == attack] for attack in ("claims", "segments", "reach")
    )
    return (
        tally(
            "No call claims more than the truth and its error.",
            ((row.beyond_m or 0.0) <= 0.0 for row in claims),
            f"{sum(row.tried for row in claims)} pairs of shapes.",
        ),
        tally(
            "No segment that is called free touches, and none is closer than its clearance.",
            (row.false_free == 0 and (row.clearance_m or 0.0) <= ROUNDING for row in segments),
            f"{sum(row.tried for row in segments)} segments, {sum(row.free or 0 for row in segments)} called free.",
        ),
        tally(
            "No point moves further than the bound says.",
            ((row.reach_m or 0.0) <= ROUNDING for row in reach),
            f"{sum(row.tried for row in reach)} segments.",
        ),
    )


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The tables for people: what has to hold, the worst claims, the segments, the reach, and whatever broke them."""
    lines = ["# python -m benchmarks attack", "", *aim_lines(aims(rows))]
    for attack, columns in _COLUMNS.items():
        chosen = [row for row in rows if row.attack == attack]
        if chosen:
            lines += ["", f"## {attack}", "", *_table(chosen, columns)]
    broken = [row for row in rows if _is_broken(row)]
    lines += ["", *(f"- {row.library} {row.attack}, {row.first} and {row.second}: {row.found}" for row in broken)]
    return "\n".join([*lines, *closing_lines(rows, complete, "attacks", _METHOD)]) + "\n"


def _is_broken(row: Row) -> bool:
    return any(aim.confirmed < aim.of for aim in aims([row]))


_COLUMNS = {
    "claims": (
        "tried",
        "apart",
        "distances_m",
        "coarse_m",
        "close_m",
        "verdict_m",
        "beyond_m",
        "short_m",
    ),
    "segments": ("tried", "free", "false_free", "clearance_m"),
    "reach": ("tried", "reach_m", "share"),
}


def _table(rows: Sequence[Row], columns: Sequence[str]) -> list[str]:
    """A line for each pair and library, the libraries of a pair one below the other."""
    order = {name: k for k, name in enumerate(BACKENDS)}
    pairs = list(dict.fromkeys((row.first, row.second) for row in rows))
    rows = sorted(rows, key=lambda row: (pairs.index((row.first, row.second)), order.get(row.library, 0)))
    lines: list[list[Any]] = [[row.first, row.second, row.library, *(getattr(row, c) for c in columns)] for row in rows]
    header = ["first", "second", "library", *(c.replace("_m", " (m)").replace("_", " ") for c in columns)]
    return markdown_table(header, lines, texts=3)


_METHOD = """How. Hill climbing from random starts, stopped on counts, looks for the largest claim minus truth. Claims:
two random shapes (1 mm to 3 m, meshes of plates, loose and degenerate triangles, boxes and strips) beside each other,
up to a kilometre from the origin, one carried by an arm and the other an obstacle or carried too. Asked are
`distances` of the checker, `coarse` and `close` of the bounds that prove, and for one pair in twelve the verdict on
the state with a margin that is not kept, or on an overlap. Segments: one that an arm of two joints, or a robot, moves
past one shape, put to the prover; where that says free the true distance along it is minimised. Reach: how far points
of every body of a robot really move. The truth is computed by Wolfe's algorithm between convex parts, triangle by
triangle: two points bound it from above, a plane from below ("open" in the table as CSV is the widest gap between
both), and touching is 0. "Short" is truth minus claim: safe, but such edges are left unproven. Limitations. A search
finds what it finds: no claim above the truth is no proof that there is none. The true distance along a segment is that
at places, the nearest refined: a contact may be missed, never invented. Verdicts on overlaps of two meshes are not
attacked, nor meshes of many triangles."""
