"""``benchmarks tasks``: seeded tasks planned at once and greedily on the same roadmaps, and looked at closely."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.bench import closing_lines, run_bench, software
from benchmarks.results import Results
from benchmarks.tasks.scenes import KINDS, seeded_task
from planner import gabf
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.base.tables import markdown_table, median
from planner.problem.request import SERIAL, TimingRequest, WorkersRequest, require_nodes, require_seed
from planner.tasks.plan import TaskPlanner
from planner.tasks.search import LazySearch

STEP = 1e-4  # m of motion between the states at which a motion is looked at again
_TENFOLD = 10  # times as many nodes, where a task was not solved


@dataclass(frozen=True)
class Row:
    """One task. ``grasps`` and ``pairs`` of a grasp and a placement were tried; ``nodes_all`` has the network.

    ``tenfold``: how it ended with ten times the nodes, asked where it was not solved. ``greedy_cost``: best grasp
    first, then path, then placement, on the same network; None where that got ``stuck``. ``segments_bad``: of the
    proven motion, with a contact every 0.1 mm. ``again_s``: at another beta. Seconds are of the processor.
    """

    kind: str
    number: int
    nodes: int
    seed: int
    outcome: str
    message: str
    tenfold: str
    grasps: int
    pairs: int
    modes: int | None
    nodes_all: int | None
    rounds: int | None
    cost: float | None
    greedy_cost: float | None
    stuck: bool
    proven: bool | None
    segments_bad: int | None
    duration: float | None
    first_s: float
    again_s: float | None
    software: str

    @property
    def key(self) -> tuple:
        """What was asked."""
        return self.kind, self.number, self.nodes, self.seed, self.software


def bench_tasks(
    folder: Path,
    scenes: int = 8,
    nodes: int = 500,
    kinds: Sequence[str] = KINDS,
    seed: int = 0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> Results[Row]:
    """Plan ``scenes`` tasks of each kind with 200 grasps and 20 placements; write ``tasks.csv`` and ``tasks.md``.

    Rows that are there already are kept. Raises OptionError for numbers out of range, FileError where the folder
    cannot be used.
    """
    require_seed(seed)
    require_nodes(nodes)
    if scenes < 1 or not set(kinds) <= set(KINDS):
        raise OptionError(f"give at least 1 scene, and kinds out of {', '.join(KINDS)}.")
    here = software()
    return run_bench(
        folder,
        "tasks",
        Row,
        [(kind, number) for kind in kinds for number in range(scenes)],
        lambda table, case: table.find((*case, nodes, seed, here)),
        partial(_measure, nodes=nodes, seed=seed),
        to_markdown,
        "tasks",
        progress,
        workers=workers,
    )


def _measure(case: tuple[str, int], progress: Progress, nodes: int, seed: int) -> list[Row]:
    task, begun = seeded_task(*case, seed), time.process_time()
    planner = TaskPlanner.of(task, nodes=nodes, seed=seed)
    found = planner.plan()
    first = time.process_time() - begun
    tried, net = planner.options.tried, planner.network
    row = Row(
        *case,
        nodes,
        seed,
        found.outcome.key,
        found.message,
        "",
        tried[0].of,
        tried[1].of,
        None if net is None else len(net.modes),
        None if net is None else net.nodes,
        found.rounds,
        None,
        None,
        False,
        None,
        None,
        None,
        first,
        None,
        software(),
    )
    if progress.stopped:
        return []
    if not found.solved:
        more = TaskPlanner.of(task, nodes=_TENFOLD * nodes, seed=seed).plan()
        return [replace(row, tenfold=more.outcome.key)]
    assert found.cost is not None
    cost, timed = greedy_cost(planner), planner.plan(timing=TimingRequest())
    begun = time.process_time()
    planner.plan(beta=0.3)
    again = time.process_time() - begun
    assert timed.trajectory is not None
    bad = sum(not report.ok for report in timed.check(STEP))
    return [
        replace(
            row,
            cost=found.cost.total,
            greedy_cost=cost,
            stuck=cost is None,
            proven=timed.trajectory.proven,
            segments_bad=bad,
            duration=timed.trajectory.duration,
            again_s=again,
        )
    ]


def greedy_cost(planner: TaskPlanner, beta: float = 0.5) -> float | None:
    """The cost of doing each step as cheaply as it can be, whatever comes after; None where that gets stuck.

    On the same network and proofs: from where it is to the cheapest end of the step, then from there on.
    """
    network, total, start = planner.network, 0.0, planner.network and planner.network.start
    assert network is not None and start is not None  # noqa: PT018
    for step in range(len(planner.task.steps)):
        ends = [way.last for way in network.ways if way.step == step]
        part = replace(network, start=start, goals=np.array(ends, dtype=np.int64))
        found = LazySearch(planner.options.modes, part, gabf.named_law("singularity-free", 4.0)).path(beta)
        if not len(found.arcs):
            return None
        total += float(network.costs[found.arcs].sum(axis=0) @ [1 - beta, beta])
        start = int(network.heads[found.arcs[-1]])
    return total


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The table for people, by kind of scene and of all."""
    groups = [(kind, [row for row in rows if row.kind == kind]) for kind in dict.fromkeys(row.kind for row in rows)]
    header = [
        "scenes",
        "tasks",
        "solved",
        "of those that 10 x the nodes solve",
        "segments with a contact",
        "not proven",
    ]
    header += ["greedy stuck", "greedy dearer (median)", "first (s)", "again (ms)"]
    lines = ["# python -m benchmarks tasks", ""]
    lines += markdown_table(header, [_line(name, group) for name, group in (*groups, ("all", list(rows)))])
    return "\n".join([*lines, *closing_lines(rows, complete, "tasks", _METHOD)]) + "\n"


def _line(name: str, rows: list[Row]) -> list[object]:
    done = [row for row in rows if row.outcome == "solved"]
    can = len(done) + sum(row.tenfold == "solved" for row in rows)
    dearer = median(row.greedy_cost / row.cost - 1 for row in done if row.greedy_cost and row.cost)
    again = median(row.again_s for row in done)
    return [
        name,
        len(rows),
        len(done),
        f"{len(done)} of {can}",
        sum(row.segments_bad or 0 for row in done),
        sum(not row.proven for row in done),
        sum(row.stuck for row in done),
        None if dearer is None else f"{100 * dearer:.1f} %",
        median(row.first_s for row in rows),
        None if again is None else 1e3 * again,
    ]


_METHOD = (
    "Panda; a box or a cylinder among others, on a table, in a bin, on a shelf, onto a block, home again: up to 200 "
    "generated grasps, 20 placements, beta 0.5. Greedy does each step as cheaply as it can, on the same network and "
    "proofs. Motions are looked at every 0.1 mm of motion by coal in worlds built from plan.json, the object included."
)
