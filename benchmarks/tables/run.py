"""Measures problems that were published with results, and prints the published numbers with ours.

How. Every method has a process of its own; seconds are of the wall clock, once libraries, robot and scene are loaded; a
machine with other work is slower, so the processor's seconds are in tables.csv. "path only" is `planner plan
--path-only`, "beta 1" and the others `planner plan` with that beta and `--nodes`, without motion and page; "saved
roadmap" is a query at beta 1 on a roadmap of `--nodes` nodes that was grown around the scene's home configuration and
contains none of the tasks. Every motion of ours is proven. Limitations. Published numbers are of other machines, models
and work: they give a scale, and no ranking follows from them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks import bench
from benchmarks.tables.case import SAVED
from benchmarks.tables.published import GCS, GCS_TASKS
from benchmarks.tables.report import aims, fault
from benchmarks.tables.report import tables as _tables
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.problem.options import PAPER_NODES
from planner.problem.request import PlanRequest
from planner.robot.scene import Scene


def tables(
    out: bench.Out = Path("bench-tables"),
    nodes: int = 1000,
    betas: tuple[float, ...] = (1.0, 0.5, 0.0),
    seed: int = 0,
    debug: bench.Debug = False,
) -> int:
    """Plan the five tasks of the GCS paper on the iiwa 14, and print the published numbers with ours.

    Writes tables.csv and tables.md, which names the source and the differences.

    Args:
        nodes: Configurations in the roadmaps.
        betas: Trade-offs to plan at.
        seed: Seed of the roadmaps.
    """
    if not betas:
        raise OptionError("give at least one beta.")
    plain = PlanRequest.from_options(robot="iiwa14", scene=GCS, collision="coal", nodes=nodes, seed=seed)
    methods = {"path only": plain.with_options(path_only=True, nodes=PAPER_NODES)}
    methods |= {f"beta {beta:g}": plain.with_options(beta=beta) for beta in betas}
    methods |= {SAVED: plain.with_options(beta=1.0)}
    content = Scene.load(GCS).identity[:8]
    cases = []
    for method, request in methods.items():
        settings = request.quality.nodes, request.quality.seed, request.what.collision, content
        names = "task method nodes seed collision content"
        rows = [bench.make_settings(names, " to ".join(ends), method, *settings) for ends in GCS_TASKS]
        cases.append(bench.Case(rows, {"method": method, "tasks": GCS_TASKS, "request": request.config()}))
    return bench.run_bench(BENCH, out, cases, _measure)


def _measure(options: dict[str, Any], progress: Progress) -> Any:
    return bench.measure_apart("benchmarks.tables.case", options, progress)


BENCH = bench.Bench("tables", __doc__, _tables, aims, fault)
