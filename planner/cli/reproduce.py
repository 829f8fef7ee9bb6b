"""``planner reproduce``: the simulations of the paper."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from planner.cli.common import Flag
from planner.cli.terminal import progress, report_table, reporter, say, show, verdict_table

if TYPE_CHECKING:
    from planner.experiments.report import Progress, Report

reproduce = tyro.extras.SubcommandApp()
reproduce.__doc__ = """Reproduce a simulation of the paper: its figures, its table, and a verdict on its sentences.

Writes PNG figures and a JSON file with the table and the verdicts; Ctrl-C saves what is done.
"""


@reproduce.command
def example(out: Path = Path("reproduce-example"), seed: int = 0, debug: Flag = False) -> int:
    """The nine-node graph of the introduction.

    Args:
        out: Folder to write into.
        seed: Kept in the report; nothing in this example is random.
        debug: Show tracebacks of errors.
    """

    def run(report: Progress, stop: Callable[[], bool]) -> Report:
        from planner.experiments.example import run_example

        return run_example()

    return run_experiment(run, out)


@reproduce.command
def laws(out: Path = Path("reproduce-laws"), seed: int = 0, graphs: int = 20, debug: Flag = False) -> int:
    """Section 4.1: the control laws compared on random graphs of 500 nodes.

    Args:
        out: Folder to write into.
        seed: Seed of the random graphs.
        graphs: Number of random graphs.
        debug: Show tracebacks of errors.
    """

    def run(report: Progress, stop: Callable[[], bool]) -> Report:
        from planner.experiments.laws import run_laws

        return run_laws(graphs, seed=seed, progress=report, stop=stop)

    return run_experiment(run, out)


def run_experiment(run: Callable[[Progress, Callable[[], bool]], Report], folder: Path) -> int:
    """Run an experiment with a progress bar, write its report, print its table and verdicts; the exit code."""
    from planner.files import require_writable_folder
    from planner.interrupt import StopRequest

    require_writable_folder(folder)
    from planner.experiments.report import write_report

    with StopRequest() as stop, progress() as bar:
        report = run(reporter(bar), stop)
    written = write_report(report, folder)
    show(report_table(report.table))
    show(verdict_table(report.verdicts))
    say("Written: " + ", ".join(map(str, written)))
    return 0 if report.complete else 130
