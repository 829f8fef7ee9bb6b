"""``python -m reproduce``: the simulations of the paper."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, TypeAlias

import tyro
from rich.console import Console
from rich.table import Table
from rich.text import Text

from planner.base.errors import printable
from planner.base.progress import Progress
from planner.cli.common import Debug, Out
from planner.cli.terminal import report_table, run_into, say
from planner.problem.options import PAPER_NODES
from planner.problem.request import RoadmapQuality
from reproduce.report import Report, write_report
from reproduce.verdict import Verdict

Seed: TypeAlias = Annotated[int, tyro.conf.arg(help="Seed of everything random; the same seed gives the same numbers.")]
Jobs: TypeAlias = Annotated[int, tyro.conf.arg(help="Processes at once, one per core by default.")]
CORES = os.cpu_count() or 1

_WIDEST = 1000  # columns of a table that no terminal shows

simulations = tyro.extras.SubcommandApp()


@simulations.command
def example(out: Out = Path("reproduce-example"), seed: Seed = 0, debug: Debug = False) -> int:
    """The nine-node graph of the introduction. Takes a second."""
    from reproduce.example import run_example

    return reproduce(out, seed, lambda _: run_example(seed))


@simulations.command
def laws(
    out: Out = Path("reproduce-laws"), seed: Seed = 0, graphs: int = 20, jobs: Jobs = CORES, debug: Debug = False
) -> int:
    """Section 4.1: the control laws compared on random graphs of 500 nodes. Takes four minutes on two cores.

    Args:
        graphs: Number of random graphs.
    """
    from reproduce.laws.run import run_laws

    return reproduce(out, seed, lambda progress: run_laws(graphs, seed=seed, jobs=jobs, progress=progress))


@simulations.command
def manipulator(
    out: Out = Path("reproduce-manipulator"),
    seed: Seed = 0,
    seeds: int = 10,
    nodes: int = PAPER_NODES,
    jobs: Jobs = CORES,
    debug: Debug = False,
) -> int:
    """Section 4.2: the manipulator among obstacles, its path for each beta and RRT's. Takes a minute on two cores.

    Args:
        seeds: Number of roadmaps, of this seed and of those that follow; every beta is solved on each.
        nodes: Configurations in each roadmap.
    """
    from reproduce.manipulator.run import run_manipulator

    return reproduce(out, seed, lambda progress: run_manipulator(seeds, nodes, seed, jobs, progress))


@simulations.command
def learning(
    out: Out = Path("reproduce-learning"),
    seed: Seed = 0,
    graphs: int = 100,
    iterations: int = 6,
    jobs: Jobs = CORES,
    debug: Debug = False,
) -> int:
    """Section 4.3: weights that are learned on random graphs of 36 nodes. Takes two minutes on two cores.

    Args:
        graphs: Number of connected random graphs.
        iterations: Training iterations on each graph.
    """
    from reproduce.learning.run import run_learning

    return reproduce(out, seed, lambda progress: run_learning(graphs, iterations, seed, jobs, progress))


def run(arguments: list[str]) -> int:
    """The exit code of the simulation that ``arguments`` name."""
    return simulations.cli(
        prog="python -m reproduce",
        description="Reproduce a simulation of the paper: its figures (PNG) and a JSON file with its table and a "
        "verdict on each of its sentences, which are also printed. Ctrl-C saves the cases that are complete.",
        args=arguments,
    )


def reproduce(folder: Path, seed: int, simulate: Callable[[Progress], Report]) -> int:
    """Run a simulation, write its report, print its verdicts, and its table where that fits; the exit code."""
    RoadmapQuality(seed=seed)  # refuses a seed out of range
    report = run_into(folder, simulate)
    written = write_report(report, folder)
    console, table = Console(), report_table(report.table)
    if console.measure(table, options=console.options.update(width=_WIDEST)).maximum <= console.width:
        console.print(table)
    console.print(verdict_table(report.verdicts))
    say("Written: " + ", ".join(map(str, written)))
    return 0 if report.complete else 130


def verdict_table(verdicts: tuple[Verdict, ...]) -> Table:
    """The number of cases that confirm each sentence, the sentence, and the measured values below it."""
    table = Table("confirmed", "sentence", title="The paper's sentences", show_lines=True)
    for verdict in verdicts:
        style = "green" if verdict.holds else "yellow" if verdict.confirmed else "red"
        text = Text(printable(verdict.sentence))
        if verdict.note:
            text.append("\n" + printable(verdict.note), style="dim")
        table.add_row(Text(f"{verdict.confirmed} of {verdict.of}", style=style), text)
    return table
