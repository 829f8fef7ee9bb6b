"""The rows of ``benchmarks proofs``, and what they add up to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.bench import aim_lines, closing_lines
from planner.base.tables import markdown_table
from reproduce.verdict import Verdict, tally

_COUNTS = ("proven", "both", "only_ours", "only_ours_touching", "only_theirs", "only_theirs_touching")


@dataclass(frozen=True)
class Row:
    """Motions in one scene by us and by one ``method`` of HPP. Up to ``software``: what was asked.

    ``proven`` by us, by ``both``, ``only_ours``, ``only_theirs``; of these two so many on which coal sees a contact at
    0.1 mm of motion. ``ours_s``, ``theirs_s``: seconds of the wall clock for all. None where HPP cannot be told of the
    scene; ``message`` says why, or what is touched.
    """

    problem: str
    method: str
    seed: int
    robot: str
    motions: int
    content: str
    software: str
    message: str = ""
    proven: int | None = None
    both: int | None = None
    only_ours: int | None = None
    only_ours_touching: int | None = None
    only_theirs: int | None = None
    only_theirs_touching: int | None = None
    ours_s: float | None = None
    theirs_s: float | None = None

    @property
    def key(self) -> tuple:
        """What was asked."""
        return self.problem, self.method, self.seed, self.robot, self.motions, self.content, self.software


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The report for people."""
    methods = dict.fromkeys(row.method for row in rows)
    lines = [_cells(method, _compared(rows, method)) for method in methods]
    text = ["# python -m benchmarks proofs", "", *markdown_table(_HEADER, lines), "", *aim_lines(aims(rows)), ""]
    text += [f"- {row.problem}, {row.method}: {row.message}" for row in rows if row.message]
    return "\n".join([*text, *closing_lines(rows, complete, "scenes", _METHOD)]) + "\n"


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What is meant to hold of our proofs."""
    of = [row for row in rows if row.proven is not None]
    return (tally("No motion touches that we alone prove.", (row.only_ours_touching == 0 for row in of), ""),)


def _compared(rows: Sequence[Row], method: str) -> list[Row]:
    return [row for row in rows if row.method == method and row.proven is not None]


_HEADER = ["HPP's method", "scenes", "motions", "proven by us", "by both", "by us alone", "of these touch"]
_HEADER += ["by HPP alone", "of these touch", "ours (ms a motion)", "HPP's (ms a motion)"]


def _cells(method: str, rows: Sequence[Row]) -> list[Any]:
    motions = sum(row.motions for row in rows)
    counts = [sum(getattr(row, name) for row in rows) for name in _COUNTS]
    seconds = [sum(getattr(row, name) for row in rows) for name in ("ours_s", "theirs_s")]
    return [method, len(rows), motions, *counts, *(1e3 * value / motions if motions else None for value in seconds)]


_METHOD = """How. In the scene of every problem random straight motions begin at free configurations, and take a random
share of the way to random others. The same URDF, limits, link pairs and obstacles are told to both. Ours: the prover of
all edges. HPP: its continuous validation, by Dichotomy without a tolerance and by Progressive with 0.1 mm, which it
needs, in the environment of `--python`. Motions that one of them proves alone are looked at by coal at every 0.1 mm;
those that do not touch have been left out by the other, as they pass within its resolution of something. Limitations.
Contacts that a look at every 0.1 mm misses are not seen. HPP is asked motion by motion from Python, our prover all at
once on all cores: its figures are no measure of the method."""
