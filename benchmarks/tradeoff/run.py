"""Measures how much a plan at one beta costs, as a share of the sweep's path at that beta on the same seed.

How. Both costs are sums along the path of the network that each searched, on one scale: that of the roadmap as it grew,
which both share. Seconds are of the processor, all stages without the page; a sweep's are those of all its motions.
Limitations. Two scenes.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks import bench
from planner.base.progress import Progress
from planner.planning.plan import plan
from planner.problem.request import PlanRequest, SweepRequest
from planner.tradeoff.sweep import sweep

_WORLDS = (("iiwa14", "paper"), ("panda", "shelf"))
_MOST = 1.005


@dataclass(frozen=True)
class Row(bench.Row):
    """A plan and the sweep's path at its ``beta``; ``ratio`` of their costs, ``cpu_s`` of the plan and of the sweep."""

    robot: str
    scene: str
    nodes: int
    seed: int
    beta: float
    software: str
    plan_cost: float | None = None
    sweep_cost: float | None = None
    ratio: float | None = None
    plan_cpu_s: float | None = None
    sweep_cpu_s: float | None = None


def tradeoff(
    out: bench.Out = Path("bench-tradeoff"),
    seeds: int = 20,
    betas: tuple[float, ...] = (0.0, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0),
    nodes: int = 1012,
    debug: bench.Debug = False,
) -> int:
    """Plans at single betas against the paths of a sweep at these betas, on the same seeds.

    Writes tradeoff.csv, one row a plan, and tradeoff.md. Exit code 4: a plan costs more than 1.005 of the sweep's path.

    Args:
        seeds: Seeds from 0 on.
        betas: Trade-offs to plan at.
        nodes: Configurations in the roadmaps.
    """
    here, cases = bench.software(), []
    for (robot, scene), seed in itertools.product(_WORLDS, range(seeds)):
        cases.append(
            bench.Case(
                tuple(Row(robot, scene, nodes, seed, beta, here) for beta in betas), (robot, scene, nodes, seed, betas)
            )
        )
    return bench.run_bench(BENCH, out, cases, _measure)


def _measure(task: tuple[str, str, int, int, tuple[float, ...]], progress: Progress) -> list[bench.Columns] | None:
    robot, scene, nodes, seed, betas = task
    options, columns, begin = {"robot": robot, "scene": scene, "nodes": nodes, "seed": seed}, [], time.process_time()
    swept = sweep(request=SweepRequest.from_options(**options), progress=progress)
    sweep_s = time.process_time() - begin
    for beta in betas:
        begin = time.process_time()
        alone = plan(request=PlanRequest.from_options(**options, beta=beta), progress=progress)
        plan_s = time.process_time() - begin
        if progress.stopped:
            return None
        own, path = alone.cost, swept.at(beta).cost
        if own is None or path is None:
            columns.append({})
            continue
        costs = {"plan_cost": own.total, "sweep_cost": path.total, "ratio": own.total / path.total}
        columns.append(costs | {"plan_cpu_s": plan_s, "sweep_cpu_s": sweep_s})
    return columns


def tables(rows: Sequence[Row]) -> list[str]:
    """A line per world and beta."""
    columns: dict[str, bench.Pick] = {
        "plans": len,
        "ratio": bench.middle("ratio"),
        "largest": bench.most("ratio"),
        "plan (CPU s)": bench.middle("plan_cpu_s"),
        "sweep (CPU s)": bench.middle("sweep_cpu_s"),
    }
    return bench.table(rows, ["robot", "scene", "beta"], columns)


def aims(rows: Sequence[Row]) -> tuple[bench.Verdict, ...]:
    """What is meant to hold."""
    held = [row.ratio is not None and row.ratio <= _MOST for row in rows]
    return (bench.tally(f"A plan costs at most {_MOST:g} of the sweep's path at its beta.", held, ""),)


BENCH = bench.Bench("tradeoff", Row, __doc__, tables, aims, must_hold=True)
