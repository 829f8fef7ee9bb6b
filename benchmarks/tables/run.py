"""Measures problems that were published with results: ours beside the published numbers.

How. Every method has a process of its own; seconds are of the wall clock, once libraries, robot and scene are loaded; a
machine with other work beside is slower, so the processor's seconds are in tables.csv. "path only" is `planner plan
--path-only`, "beta 1" and the others `planner plan` with that beta and `--nodes`, without motion and page; "kept
roadmap" is a query at beta 1 on a roadmap of `--nodes` nodes that was grown around the scene's home configuration and
knows none of the tasks. Every motion of ours is proven. Limitations. Published numbers are of other machines, models
and work: they stand here so that ours can be judged, not as a race.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks import bench
from benchmarks.problems import find_problems
from benchmarks.processes import plain_options
from benchmarks.tables.case import KEPT
from benchmarks.tables.published import GCS, GCS_TASKS, MBM
from benchmarks.tables.report import Row, aims, fault
from benchmarks.tables.report import tables as _tables
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.problem.options import PAPER_NODES
from planner.problem.request import PlanRequest
from planner.robot.scene import Scene

PATH_ONLY = "path only"


def tables(
    folder: bench.OptionalFolder = None,
    out: bench.Out = Path("bench-tables"),
    nodes: int = 1000,
    betas: tuple[float, ...] = (1.0, 0.5, 0.0),
    seed: int = 0,
    debug: bench.Debug = False,
) -> int:
    """Problems that were published with results: ours beside the published numbers, their sources, and what differs.

    The five tasks of the GCS paper on the iiwa 14; with a FOLDER, its problems for the Panda, as 'plan'
    has them, beside what VAMP publishes for MotionBenchMaker's. Writes tables.csv and tables.md, which also names what
    could not be had.

    Args:
        folder: Folder of MotionBenchMaker's problems for the Panda; the tables of these are left out without it.
        nodes: Configurations in the roadmaps.
        betas: Trade-offs to plan at.
        seed: Seed of the roadmaps.
    """
    if not betas:
        raise OptionError("give at least one beta.")
    plain = PlanRequest.from_options(robot="iiwa14", scene=GCS, collision="coal", nodes=nodes, seed=seed)
    content = Scene.load(GCS).identity[:8]
    methods = _methods(plain, betas) | {KEPT: plain.with_options(beta=1.0)}
    cases = [_case(GCS, method, request, GCS_TASKS, content) for method, request in methods.items()]
    plain = plain.with_options(robot="panda", widen_limits=True)
    for problem in [] if folder is None else find_problems(folder):
        for method, request in _methods(problem.asked(plain), betas).items():
            cases.append(_case(MBM, method, request, (("", ""),), problem.content(plain), problem.name))
    return bench.run_bench(BENCH, out, cases, _measure)


def _methods(plain: PlanRequest, betas: tuple[float, ...]) -> dict[str, PlanRequest]:
    """The request of every method, by its name; ``plain`` has the nodes of the roadmaps."""
    found = {PATH_ONLY: plain.with_options(path_only=True, nodes=PAPER_NODES)}
    return found | {f"beta {beta:g}": plain.with_options(beta=beta) for beta in betas}


def _case(
    table: str, method: str, request: PlanRequest, tasks: tuple[tuple[str, str], ...], content: str, name: str = ""
) -> bench.Case[Row]:
    """Tasks (start, goal) of one scene by one method; an empty start is the request's own."""
    asked = request.quality.nodes, request.quality.seed, request.what.collision, content, bench.software()
    rows = tuple(Row(table, name or f"{start} to {goal}", method, *asked) for start, goal in tasks)
    return bench.Case(rows, {"method": method, "tasks": tasks, "request": plain_options(request)})


def _measure(options: dict[str, Any], progress: Progress) -> Any:
    return bench.measure_apart("benchmarks.tables.case", options, progress)


BENCH = bench.Bench("tables", Row, __doc__, _tables, aims, fault)
