"""The rows of ``benchmarks agreement``, and the tables of them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.agreement.check_speed import ROUNDS
from benchmarks.agreement.contact_band import band
from benchmarks.bench import aim_lines, closing_lines
from planner.base.tables import markdown_table, median
from reproduce.verdict import Verdict, tally


@dataclass(frozen=True)
class Row:
    """One robot in one scene. Counts of configurations; speeds in microseconds per configuration.

    ``disagreed``: the verdicts of the two libraries differ; ``unexplained``: of these, farther from a contact than the
    band. ``batch_differs``: a library that says otherwise when asked about several at once. Around ``crossings``
    contacts, ``band_m`` is the largest distance (m) at which the two still differ. The speeds are over free
    configurations: one by one, all at once, and along free edges. ``listed``: disagreements one by one, as JSON.
    """

    robot: str
    scene: str
    margin: float
    seed: int
    states: int
    free: int
    disagreed: int
    unexplained: int
    batch_differs: int
    crossings: int
    band_m: float
    fcl_single: float | None
    coal_single: float | None
    fcl_batch: float | None
    coal_batch: float | None
    fcl_edge: float | None
    coal_edge: float | None
    listed: str
    software: str

    @property
    def key(self) -> tuple:
        """What was asked."""
        return self.robot, self.scene, self.margin, self.seed, self.states, self.software


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What the two libraries are meant to show, and whether these rows do; of 0 where that was not measured."""
    paper = [row.fcl_edge for row in rows if (row.robot, row.scene) == ("iiwa14", "paper") and row.fcl_edge is not None]
    batches = [row.coal_batch for row in rows if row.coal_batch is not None]
    disagreed, states, crossings = (sum(getattr(r, n) for r in rows) for n in ("disagreed", "states", "crossings"))
    widest = max((row.band_m for row in rows), default=0.0)
    bands = ", ".join(f"{band(margin):g} m" for margin in sorted({row.margin for row in rows}))
    return (
        tally(
            f"Verdicts differ only within {bands} of a contact.",
            (row.unexplained == 0 and row.band_m <= band(row.margin) for row in rows),
            f"Of {states} random states {disagreed} disagreed; around {crossings} contacts up to {widest:.1e} m.",
        ),
        tally("A library says the same of one state and of many.", (row.batch_differs == 0 for row in rows), ""),
        tally(
            "Coal takes at most 10 us per state in batches.",
            (value <= 10.0 for value in batches),
            f"Median {median(batches):.1f} us, most {max(batches):.1f} us." if batches else "",
        ),
        tally(
            "FCL takes at most 45 us per state along edges of iiwa14 in the paper's scene.",
            (value <= 45.0 for value in paper),
            ", ".join(f"{value:.1f} us" for value in paper),
        ),
    )


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The table as Markdown: one line per robot and scene, the aims, and every disagreement."""
    header = ["robot", "scene", "states", "free", "disagreed", "unexplained", "band (m)", "FCL one by one (us)"]
    header += ["batch", "edge", "coal one by one (us)", "batch", "edge", "FCL / coal edge"]
    lines = ["# python -m benchmarks agreement", "", *markdown_table(header, map(_cells, rows), texts=2), ""]
    lines += [*aim_lines(aims(rows)), *_list_of_disagreements(rows)]
    return "\n".join([*lines, *closing_lines(rows, complete, "worlds", _METHOD)]) + "\n"


def _cells(row: Row) -> list[Any]:
    ratio = row.fcl_edge / row.coal_edge if row.fcl_edge and row.coal_edge else None
    counts = [row.robot, row.scene, row.states, row.free, row.disagreed, row.unexplained, row.band_m]
    return [*counts, row.fcl_single, row.fcl_batch, row.fcl_edge, row.coal_single, row.coal_batch, row.coal_edge, ratio]


def _list_of_disagreements(rows: Sequence[Row]) -> list[str]:
    listed = [(row, one) for row in rows for one in json.loads(row.listed)]
    if not listed:
        return []
    header = ["robot", "scene", "touching by", "pair", "FCL (m)", "coal (m)", "q"]
    lines = [
        [row.robot, row.scene, one["touching_by"], f"{one['first']}, {one['second']}", *_two_distances(one), one["q"]]
        for row, one in listed
    ]
    return ["", "Disagreements:", "", *markdown_table(header, lines, texts=4)]


def _two_distances(one: dict[str, Any]) -> list[str]:
    return ["-" if one[name] is None else f"{one[name]:.5e}" for name in ("fcl_m", "coal_m")]


_METHOD = f"""How. Random configurations within the limits are put to both libraries one by one. Where they differ, the
pair that one of them finds touching is measured by both; the disagreement is explained when coal puts that pair within
{band(0.0):g} m of touching. With a margin it is {band(1.0):g} m of the margin, since FCL's distances are lowered to
what a plane proves. Random states hardly ever fall there, so the places at which FCL's verdict turns are bisected
between free and touching configurations, and both are asked from a nanometre of motion on either side outwards: the
band is the largest distance at which they still differed. Speeds are medians of {ROUNDS} interleaved rounds over the
same free configurations; edges have states every 2 cm of motion, about a hundred each; in batches and along edges FCL
is asked only where cheap bounds on the distances cannot tell, as the planner does. Limitations. Only verdicts on
single states are compared: a distance that a library measures wrongly, and a proof of a motion that rests on it, are
not seen here as long as both libraries see the contact itself. FCL's prover once called segments beside large triangles
free that touch, and this benchmark found nothing: `python -m benchmarks attack` looks for that. On a shared machine
read the ratios, not the microseconds. Coal uses every core in batches and along edges. Touching configurations are
quicker than free ones for both."""
