"""The rows of ``benchmarks motion``, and what they add up to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.bench import aim_lines, closing_lines
from planner.base.tables import markdown_table, median
from reproduce.verdict import Verdict, tally

SHARE_OF_STOPPING, OVER_TOPPRA, SECONDS = 0.60, 1.05, 0.15


@dataclass(frozen=True)
class Row:
    """One problem, planned once and timed. Up to ``software``: what was asked; then the results, None without a path.

    ``limits``: in words. ``timed_s``, ``blended_s``, ``stopping_s``: durations with shortcuts in time, with rounded
    corners only, and with a stop at each, jerk limits kept; ``toppra_s``: toppra's along the curve of the first,
    without them, None where it is not installed. ``corners``, those ``blended``, and ``shortcuts``.
    ``proven``: as a whole. ``largest_share`` of any limit, 1 is all of it.
    ``contact``: the first one that the other library sees at 0.1 mm of motion. ``cpu_s``: for the first motion.
    ``roboplan_s``, ``roboplan_share`` of a limit at its samples, ``roboplan_contact``: of its time
    parametrization over the same path.
    """

    problem: str
    kind: str
    seed: int
    robot: str
    collision: str
    nodes: int
    limits: str
    content: str
    software: str
    outcome: str
    message: str
    timed_s: float | None = None
    blended_s: float | None = None
    stopping_s: float | None = None
    toppra_s: float | None = None
    corners: int | None = None
    blended: int | None = None
    shortcuts: int | None = None
    proven: bool | None = None
    largest_share: float | None = None
    contact: str | None = None
    knots: int | None = None
    cpu_s: float | None = None
    roboplan_s: float | None = None
    roboplan_share: float | None = None
    roboplan_contact: str | None = None

    @property
    def key(self) -> tuple:
        """What was asked."""
        asked = (self.problem, self.seed, self.robot, self.collision, self.nodes, self.limits)
        return *asked, self.content, self.software


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The report for people."""
    kinds = dict.fromkeys(row.kind for row in rows)
    lines = [_cells(kind, [row for row in rows if row.kind == kind]) for kind in kinds]
    table = markdown_table(_HEADER, [*lines, _cells("all", rows)])
    bad = [f"- {row.problem}: {row.contact or row.message}" for row in rows if row.contact or row.timed_s is None]
    limits = "; ".join(dict.fromkeys(row.limits for row in rows))
    text = ["# python -m benchmarks motion", "", *table, "", *aim_lines(aims(rows)), *([""] if bad else []), *bad]
    return "\n".join([*text, "", f"Limits: {limits}.", *closing_lines(rows, complete, "problems", _METHOD)]) + "\n"


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What motions are meant to be, and whether these are."""
    timed = [row for row in rows if row.outcome == "solved"]
    share, over = median(map(_share, timed)), median(map(_over_toppra, timed))
    seconds = median(row.cpu_s for row in timed)
    return (
        tally("Every path that is found is timed.", (row.timed_s is not None for row in timed), ""),
        tally("Every motion is proven as a whole.", (bool(row.proven) for row in timed), ""),
        tally("The other library sees no contact at 0.1 mm of motion.", (not row.contact for row in timed), ""),
        tally(
            "No limit is exceeded.", (row.largest_share is not None and row.largest_share <= 1.0 for row in timed), ""
        ),
        tally(f"It takes {SHARE_OF_STOPPING:g} of stopping or less.", _holds(share, SHARE_OF_STOPPING), _of(share)),
        tally(f"It takes {OVER_TOPPRA:g} of toppra's time or less.", _holds(over, OVER_TOPPRA), _of(over)),
        tally(f"Timing takes {SECONDS:g} s or less.", _holds(seconds, SECONDS), _of(seconds)),
    )


def _share(row: Row) -> float | None:
    return _ratio(row.timed_s, row.stopping_s)


def _over_toppra(row: Row) -> float | None:
    return _ratio(row.timed_s, row.toppra_s)


def _ratio(value: float | None, other: float | None) -> float | None:
    return None if value is None or not other else value / other


def _holds(value: float | None, limit: float) -> list[bool]:
    return [] if value is None else [value <= limit]


def _of(value: float | None) -> str:
    return "" if value is None else f"In the median {value:.3g}."


_HEADER = ["scene type", "problems", "timed", "proven", "contacts", "largest share", "corners", "rounded", "shortcuts"]
_HEADER += ["ours (s)", "stopping (s)", "share", "share, only rounded", "over toppra", "knots", "CPU (s)"]
_HEADER += ["over roboplan", "its largest share", "its contacts"]


def _cells(name: str, rows: Sequence[Row]) -> list[Any]:
    timed = [row for row in rows if row.timed_s is not None]
    total: Callable[[str], int] = lambda column: sum(getattr(row, column) for row in timed)  # noqa: E731
    middle: Callable[[str], float | None] = lambda column: median(getattr(row, column) for row in timed)  # noqa: E731
    counts = [len(rows), len(timed), total("proven"), sum(bool(row.contact) for row in timed)]
    most = max((row.largest_share for row in timed if row.largest_share is not None), default=None)
    cells = [name, *counts, most, *map(total, ("corners", "blended", "shortcuts")), middle("timed_s")]
    cells += [middle("stopping_s"), median(map(_share, timed))]
    cells += [median(_ratio(row.blended_s, row.stopping_s) for row in timed), median(map(_over_toppra, timed))]
    beside = [row for row in timed if row.roboplan_s is not None]
    its_most = max((row.roboplan_share for row in beside if row.roboplan_share is not None), default=None)
    cells += [middle("knots"), middle("cpu_s"), median(_ratio(row.timed_s, row.roboplan_s) for row in beside), its_most]
    return [*cells, sum(bool(row.roboplan_contact) for row in beside) if beside else None]


_METHOD = """How. Every problem is planned once, and its path is timed with shortcuts, with rounded corners only, and
with a stop at each. Durations, shares and CPU seconds are medians. Limits are compared with the exact extrema of the
pieces between knots, contacts looked for by the collision library that has not planned, at states no more than 0.1 mm
of motion apart. toppra (where it is installed) runs along the same curve, between the same stops, with limits on
velocity and acceleration at its own grid; ours keeps limits on jerk too. roboplan (where --python has it) times the
same path by its default spline and TOPP-RA; its share of a limit is that of its own samples, of which a controller
makes cubics. Limitations. States every 0.1 mm are no proof. The stopping motion, too, limits the jerk, for which it
waits a few milliseconds at each corner. sscbirrt times only what it has checked itself, so it has no column."""
