"""``planner sweep``."""

from __future__ import annotations

from pathlib import Path

from planner.base.files import require_writable_folder
from planner.base.interrupts import leaving_on_interrupt
from planner.cli.common import Debug, Out, Problem, command_clock, folder_for_interrupted, kept
from planner.cli.terminal import report_table, say, show, working
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
    require_writable_folder(out)
    from planner.tradeoff.sweep import sweep as find_tradeoff

    clock = command_clock()
    with working() as progress:
        result = find_tradeoff(SweepRequest(what, quality), progress)
        interrupted = result.outcome is Outcome.INTERRUPTED
        place = folder_for_interrupted(out, result.FILES) if interrupted else out
        record = result.save_without_page(place, clock)
        files, ending = [str(place / name) for name in result.FILES if name != result.PAGE], result.outcome.value
        if result.outcome is Outcome.SOLVED:
            count = len(result.intervals)
            ending = f"{count} path{'s are' if count != 1 else ' is'} optimal, each in its interval of beta."
        with leaving_on_interrupt(f"stopping without the page. {ending} Written: {', '.join(files)}"):
            if not progress.stopped:
                record = result.save_page(place, record, clock)
                files = [str(place / name) for name in result.FILES]
    if record.intervals:
        show(report_table(record.table))
    for line in record.lines:
        say(line)
    say("Seconds: " + ", ".join(f"{stage} {value:.2f}" for stage, value in record.timings_s.items()) + ".")
    say(f"{ending} Written: {', '.join(files)}{kept(out, place)}")
    return Outcome.INTERRUPTED.exit_code if progress.stopped else result.outcome.exit_code
