"""Measures tasks planned at once, against a greedy chain on the same network and proofs, and looks at the motions.

How. The Panda takes a box or a cylinder among others from a table, a bin or a shelf, puts it onto a block and goes
home: up to 200 generated grasps, 20 placements, beta 0.5. Greedy does each step as cheaply as it can. Motions are
looked at every 0.1 mm of motion by coal in worlds built from plan.json, the object included. A task that is not solved
is planned with ten times the nodes too. Seconds are of the processor. Limitations. States every 0.1 mm are no proof;
one robot, and three kinds of scenes.

Columns. One task. ``grasps`` and ``pairs`` of a grasp and a placement were tried; ``nodes_all`` has the network.

``tenfold``: how it ended with ten times the nodes, asked where it was not solved. ``greedy_cost``: best grasp first,
then path, then placement, on the same network; None where that got ``stuck``. ``segments_bad``: of the proven motion,
with a contact every 0.1 mm. ``again_s``: at another beta.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import bench
from benchmarks.tasks.scenes import KINDS, seeded_task
from planner import gabf
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.batch.run import SOLVED
from planner.problem.request import RoadmapQuality, TimingRequest
from planner.tasks.check import check
from planner.tasks.network import LazySearch
from planner.tasks.plan import TaskPlanner

STEP = 1e-4  # m of motion between the states at which a motion is looked at again
_TENFOLD = 10  # times as many nodes, where a task was not solved


def tasks(
    out: bench.Out = Path("bench-tasks"),
    scenes: int = 8,
    nodes: int = 500,
    kinds: tuple[str, ...] = KINDS,
    seed: int = 0,
    workers: bench.Workers = bench.SERIAL,
    debug: bench.Debug = False,
) -> int:
    """Something taken and put elsewhere in seeded scenes: success, contacts, times, and against a greedy chain.

    Writes tasks.csv, one row a task, and tasks.md.

    Args:
        scenes: Scenes of each kind: things on a table, in a bin, on a shelf.
        nodes: Configurations in the roadmaps.
        kinds: Kinds of scenes.
        seed: Seed of scenes and roadmaps.
    """
    RoadmapQuality(nodes, seed)  # refuses what is out of range
    if scenes < 1 or not set(kinds) <= set(KINDS):
        raise OptionError(f"give at least 1 scene, and kinds out of {', '.join(KINDS)}.")
    rows = [
        bench.make_settings("kind number nodes seed", kind, number, nodes, seed)
        for kind in kinds
        for number in range(scenes)
    ]
    return bench.run_bench(BENCH, out, [bench.Case((row,), row) for row in rows], _measure, workers)


def _measure(row: bench.Row, progress: Progress) -> dict[str, Any] | None:
    task, begun = seeded_task(row.kind, row.number, row.seed), time.process_time()
    planner = TaskPlanner.from_task(task, nodes=row.nodes, seed=row.seed)
    found = planner.plan(timing=None)
    tried, net = planner.candidates.rejected, planner.network
    columns: dict[str, Any] = {
        "outcome": found.outcome.key,
        "message": found.message,
        "rounds": 0 if found.modes is None else found.modes.rounds,
    }
    columns |= {"grasps": tried[0].of, "pairs": tried[1].of, "first_s": time.process_time() - begun}
    columns |= {} if net is None else {"modes": len(net.modes), "nodes_all": net.nodes}
    if progress.stopped:
        return None
    if not found.solved:
        more = TaskPlanner.from_task(task, nodes=_TENFOLD * row.nodes, seed=row.seed).plan(timing=None)
        return columns | {"tenfold": more.outcome.key}
    assert found.cost is not None
    cost, timed = greedy_cost(planner), planner.plan(timing=TimingRequest())
    begun = time.process_time()
    planner.plan(beta=0.3, timing=None)
    again = time.process_time() - begun
    assert timed.trajectory is not None
    return columns | {
        "cost": found.cost.total,
        "greedy_cost": cost,
        "stuck": cost is None,
        "proven": timed.trajectory.proven,
        "segments_bad": sum(not part.ok for part in check(timed, step=STEP).parts),
        "duration": timed.trajectory.duration,
        "again_s": again,
    }


def greedy_cost(planner: TaskPlanner, beta: float = 0.5) -> float | None:
    """The cost of doing each step as cheaply as it can be, whatever comes after; None where that gets stuck.

    On the same network and proofs: from where it is to the cheapest end of the step, then from there on.
    """
    network, total, start = planner.network, 0.0, planner.network and planner.network.start
    assert network is not None and start is not None  # noqa: PT018
    for step in range(len(planner.task.steps)):
        ends = [way.last for way in network.transitions if way.step == step]
        part = replace(network, start=start, goals=np.array(ends, dtype=np.int64))
        search = LazySearch(planner.candidates.modes, part, gabf.law_from_name("singularity-free", 4.0))
        _, arcs = search.path(beta)
        if not len(arcs):
            return None
        total += float(network.costs[arcs].sum(axis=0) @ [1 - beta, beta])
        start = int(network.heads[arcs[-1]])
    return total


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """A line per kind of scene, and of all."""
    solved = lambda read: lambda some: read([row for row in some if row.outcome == SOLVED])  # noqa: E731
    columns: dict[str, bench.Pick] = {
        "tasks": len,
        "solved": solved(len),
        "of those that 10 x the nodes solve": lambda some: sum(SOLVED in (row.outcome, row.tenfold) for row in some),
        "segments with a contact": solved(bench.total("segments_bad")),
        "not proven": solved(bench.total(lambda row: not row.proven)),
        "greedy stuck": bench.total("stuck"),
        "greedy dearer (median, %)": solved(bench.middle(_dearer, 100.0)),
        "first (s)": bench.middle("first_s"),
        "again (ms)": solved(bench.middle("again_s", 1e3)),
    }
    return bench.table(rows, ["kind"], columns, whole=True)


def _dearer(row: bench.Row) -> float | None:
    return row.greedy_cost / row.cost - 1 if row.greedy_cost and row.cost else None


BENCH = bench.Bench("tasks", __doc__, tables)
