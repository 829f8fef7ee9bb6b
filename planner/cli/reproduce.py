"""``planner reproduce``: the simulations of the paper."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tyro

from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.cli.common import Debug, Out, Workers
from planner.cli.terminal import report_table, run_into, say, show, verdict_table
from planner.problem.request import PAPER_NODES, SERIAL, Backend

if TYPE_CHECKING:
    from planner.reproduce.report import Report

reproduce = tyro.extras.SubcommandApp()
reproduce.__doc__ = """Reproduce a simulation of the paper: its figures, its table, and a verdict on its sentences.

Writes PNG figures and a JSON file with the table and the verdicts; Ctrl-C saves what is done.
"""


@reproduce.command
def example(out: Out = Path("reproduce-example"), seed: int = 0, debug: Debug = False) -> int:
    """The nine-node graph of the introduction.

    Args:
        seed: Kept in the report; nothing in this example is random.
    """

    from planner.reproduce.example import run_example

    return reproduced(out, lambda _: run_example(seed))


@reproduce.command
def laws(
    out: Out = Path("reproduce-laws"), seed: int = 0, graphs: int = 20, workers: Workers = SERIAL, debug: Debug = False
) -> int:
    """Section 4.1: the control laws compared on random graphs of 500 nodes.

    Args:
        seed: Seed of the random graphs.
        graphs: Number of random graphs.
    """

    from planner.reproduce.laws.run import run_laws

    return reproduced(out, lambda progress: run_laws(graphs, seed=seed, progress=progress, workers=workers))


@reproduce.command
def manipulator(
    out: Out = Path("reproduce-manipulator"),
    seed: int = 0,
    seeds: int = 10,
    nodes: int = PAPER_NODES,
    collision: Backend = "fcl",
    strands: float = 0.0,
    workers: Workers = SERIAL,
    debug: Debug = False,
) -> int:
    """Section 4.2: the manipulator among obstacles, its path for each beta beside that of RRT.

    Args:
        seed: Seed of the first roadmap; the others have the seeds that follow.
        seeds: Number of roadmaps, one per seed; every beta is solved on each.
        nodes: Configurations in each roadmap.
        collision: Collision library that checks nodes and answers: FCL, or coal, which is faster.
        strands: Share of each roadmap's nodes that come from refined best paths; all others are RRT's. The paper has
            RRT's nodes only, so 0; 'planner plan' uses 0.1.
    """

    from planner.reproduce.manipulator.run import run_manipulator

    return reproduced(out, lambda progress: run_manipulator(seeds, nodes, collision, seed, strands, progress, workers))


@reproduce.command
def learning(
    out: Out = Path("reproduce-learning"),
    seed: int = 0,
    graphs: int = 100,
    iterations: int = 6,
    robot: str | None = None,
    scene: str | None = None,
    start: str | None = None,
    goal: str | None = None,
    roadmaps: int | None = None,
    nodes: int | None = None,
    executions: int | None = None,
    workers: Workers = SERIAL,
    debug: Debug = False,
) -> int:
    """Section 4.3: weights that are learned, on random graphs of 36 nodes and, if one is named, on a robot's roadmaps.

    With --robot the costs of a roadmap's edges are unknown until a path has passed near them: the study measures what
    each execution pays and what it learns. Takes about two minutes more.

    Args:
        seed: Seed of the graphs, the roadmaps and the starts.
        graphs: Number of connected random graphs.
        iterations: Training iterations on each graph.
        robot: Also learn on roadmaps of this robot (see 'planner robots') or URDF.
        scene: With --robot: the scene, "paper" where left out.
        start: With --robot: where the arm starts, the scene's own start where left out.
        goal: With --robot: where the arm should go, the scene's own goal where left out.
        roadmaps: With --robot: number of roadmaps, 8 where left out.
        nodes: With --robot: nodes of each roadmap, 300 where left out.
        executions: With --robot: paths executed on each roadmap, 200 where left out.
    """
    asked: dict[str, Any] = {"scene": scene, "start": start, "goal": goal}
    asked |= {"roadmaps": roadmaps, "nodes": nodes, "executions": executions}
    given = {name: value for name, value in asked.items() if value is not None}
    if robot is None and given:
        raise OptionError(f"{', '.join('--' + name for name in given)} asks for a robot's roadmaps: give --robot too.")

    from planner.reproduce.learning.robot import RobotSettings
    from planner.reproduce.learning.run import run_learning

    settings = RobotSettings(robot, **given) if robot else None
    return reproduced(out, lambda progress: run_learning(graphs, iterations, seed, settings, progress, workers))


def reproduced(folder: Path, run: Callable[[Progress], Report]) -> int:
    """Run an experiment, write its report, show its table and verdicts; the exit code."""
    from planner.reproduce.report import write_report

    report = run_into(folder, run)
    written = write_report(report, folder)
    show(report_table(report.table))
    show(verdict_table(report.verdicts))
    say("Written: " + ", ".join(map(str, written)))
    return 0 if report.complete else 130
