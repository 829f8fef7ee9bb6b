"""``planner sweep``."""

from __future__ import annotations

from pathlib import Path

from planner.cli.common import Debug, Out, Problem, written
from planner.cli.terminal import report_table, say, show
from planner.problem.outcome import Outcome
from planner.problem.request import SweepQuality, SweepRequest


def sweep(
    what: Problem = Problem(),  # noqa: B008 (frozen)
    quality: SweepQuality = SweepQuality(),  # noqa: B008
    out: Out = Path("sweep"),
    debug: Debug = False,
) -> int:
    """The whole trade-off between manipulability and distance: every path that some beta makes optimal.

    Finds all values of beta at which the best path changes, exactly and without a grid, on one roadmap. Starts,
    goals and all other options are those of 'planner plan'. Examples:

    planner sweep --seed 3

    planner sweep --roadmap out/roadmap.npz

    Writes sweep.json, sweep.csv, sweep.html (open it in a browser) and roadmap.npz. Exit codes are those of
    'planner plan'; Ctrl-C saves the intervals that are proven so far, without the page; where --out holds a sweep
    already, in a new folder 'interrupted' inside it.
    """
    from planner.tradeoff.sweep import sweep as find_tradeoff

    result, record, files, code = written(lambda progress: find_tradeoff(SweepRequest(what, quality), progress), out)
    ending, count = result.outcome.value, len(result.intervals)
    if result.outcome is Outcome.SOLVED:
        ending = f"{count} path{'s are' if count != 1 else ' is'} optimal, each in its interval of beta."
    if record.intervals:
        show(report_table(record.table))
    for line in record.lines:
        say(line)
    say("Seconds: " + ", ".join(f"{stage} {value:.2f}" for stage, value in record.timings_s.items()) + ".")
    say(f"{ending} {files}")
    return code
