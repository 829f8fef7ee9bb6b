"""Measures what each beta buys, and how much a plan at it costs as a share of the sweep's path on the same seed.

How. Omega, D, w, length, duration and clearance are of the sweep's path at that beta. Omega and D have no unit, and
each roadmap its own scale: compare shares of them over seeds. Both costs are sums along the path of the network that
each searched, on one scale: that of the roadmap as it grew, which both share. Seconds are of the processor, all stages
without the page; a sweep's are those of all its motions.
Limitations. Two scenes.

Columns. The sweep's path at ``beta``, and a plan there: ``ratio`` of their costs, ``cpu_s`` of the plan and of the
sweep.

The path is the best one from ``beta_min`` to ``beta_max``, w_min is in m³, length in rad, duration in s, clearance in
m; ``gain`` and ``added_length`` are its shares of what beta 0 saves in Omega and adds in D over beta 1; ``knee`` says
whether it is the knee of the front.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks import bench
from planner.base.progress import Progress
from planner.planning.plan import plan
from planner.problem.request import PlanRequest, SweepRequest
from planner.tradeoff.record import interval_at
from planner.tradeoff.result import Tradeoff
from planner.tradeoff.sweep import sweep

_WORLDS = (("iiwa14", "paper"), ("panda", "shelf"))
_MOST = 1.005


def tradeoff(
    out: bench.Out = Path("bench-tradeoff"),
    seeds: int = 20,
    betas: tuple[float, ...] = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0),
    nodes: int = 1012,
    plans: bool = True,
    debug: bench.Debug = False,
) -> int:
    """What each beta buys, over seeds, and plans at these betas against the sweep's paths.

    Writes tradeoff.csv, one row a seed and beta, and tradeoff.md. With --no-plans it writes the rows of
    notebooks/tradeoff.csv, which notebook 02 draws. Exit code 4: a plan costs more than 1.005 of the sweep's path.

    Args:
        seeds: Seeds from 0 on.
        betas: Trade-offs to plan at.
        nodes: Configurations in the roadmaps.
        plans: Plan at each beta too.
    """
    cases = []
    for world, seed in itertools.product(_WORLDS, range(seeds)):
        names = "robot scene nodes seed beta plans"
        rows = tuple(bench.make_settings(names, *world, nodes, seed, beta, plans) for beta in betas)
        cases.append(bench.Case(rows, rows))
    return bench.run_bench(BENCH, out, cases, _measure)


def _measure(rows: tuple[bench.Row, ...], progress: Progress) -> list[bench.Columns] | None:
    options: bench.Columns = {name: getattr(rows[0], name) for name in ("robot", "scene", "nodes", "seed")}
    begin, columns = time.process_time(), list[bench.Columns]()
    swept = sweep(request=SweepRequest.from_options(**options), progress=progress)
    sweep_s = time.process_time() - begin
    for row in rows:
        columns.append(_of_path(swept, row.beta))
        if not row.plans:
            continue
        begin = time.process_time()
        alone = plan(request=PlanRequest.from_options(**options, beta=row.beta), progress=progress)
        columns[-1] |= {"plan_cpu_s": time.process_time() - begin, "sweep_cpu_s": sweep_s}
        own, path = alone.cost, swept.at(row.beta).cost
        if own is not None and path is not None:
            columns[-1] |= {"plan_cost": own.total, "sweep_cost": path.total, "ratio": own.total / path.total}
    return None if progress.stopped else columns


def _of_path(swept: Tradeoff, beta: float) -> bench.Columns:
    """What the sweep's path at ``beta`` measures, to four digits; nothing where there is none."""
    item, _ = interval_at(swept.intervals, beta)
    if item is None:
        return {}
    names = {"omega": "manipulability_cost", "distance": "distance_cost", "length": "joint_length"}
    same = ("beta_min", "beta_max", "w_min", "duration", "clearance", "gain", "added_length")
    names |= {name: name for name in same}
    numbers = {name: getattr(item, field) for name, field in names.items()}
    short = {name: None if value is None else float(f"{value:.4g}") for name, value in numbers.items()}
    return short | {"knee": item is swept.knee}


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """A line per world and beta."""
    columns: dict[str, bench.Pick] = {
        "seeds": len,
        "duration (s)": bench.middle("duration"),
        "smallest w": bench.middle("w_min"),
        "length (rad)": bench.middle("length"),
        "in the knee": bench.total("knee"),
        "ratio": bench.middle("ratio"),
        "largest": bench.most("ratio"),
        "plan (CPU s)": bench.middle("plan_cpu_s"),
        "sweep (CPU s)": bench.middle("sweep_cpu_s"),
    }
    return bench.table(rows, ["robot", "scene", "beta"], columns)


def aims(rows: Sequence[bench.Row]) -> tuple[bench.Verdict, ...]:
    """What is meant to hold."""
    held = [row.ratio is not None and row.ratio <= _MOST for row in rows if row.plan_cpu_s is not None]
    return (bench.tally(f"A plan costs at most {_MOST:g} of the sweep's path at its beta.", held, ""),)


BENCH = bench.Bench("tradeoff", __doc__, tables, aims, must_hold=True)
