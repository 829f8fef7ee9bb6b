"""Measures the gap of plans for planar arms to the optimum of a fine grid, and how it falls with rounds of refinement.

How. Each arm is planar, its geometry and its w are computed in the plane, without the planner's checker and
kinematics. The optimum is the cheapest path over a grid of configurations whose edges are proven free, halved in a tube
around that path and then pulled tight; with omega scaled as the plan's roadmap scales it. Its error is what the last
halving changed. A gap below 0 says that the plan is better than the grid's path. The fit is over the rounds, to
median gaps. Limitations. Two planar arms, each in one scene.

Columns. One plan. ``cost`` and ``optimum``: finely integrated, of its path and of the grid's; ``gap``: in %. ``error``
(%): what the grid's last halving changed.

``curve``: gaps (%) after each round, separated by blanks, as plan.json's curve has them.
"""

from __future__ import annotations

import itertools
import math
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import bench
from benchmarks.optimum.arms import ARMS
from benchmarks.optimum.grid import grid_optimum, path_cost
from planner.base.errors import OptionError, PlannerError
from planner.base.progress import Progress
from planner.planning.plan import plan
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest
from planner.trajectory.measure import count_corners

_AIMS = {1000: 1.0, 5000: 0.3}  # %: the gap that is aimed at for planar_2r, by the number of nodes
_ARMS = {arm.name: arm for arm in ARMS}


def optimum(
    out: bench.Out = Path("bench-optimum"),
    nodes: tuple[int, ...] = (1000, 5000),
    refinement_rounds: tuple[int, ...] = (6, 30),
    betas: tuple[float, ...] = (0.0, 1.0),
    seeds: tuple[int, ...] = (0, 1, 2),
    arms: tuple[str, ...] = ("planar_2r", "planar_3r"),
    debug: bench.Debug = False,
) -> int:
    """Compare plans of planar arms with the optimum of a fine grid: the gap, and how it falls with the rounds.

    The grid has its own geometry and manipulability, computed in the plane. Writes optimum.csv, one row a plan, and
    optimum.md.

    Args:
        nodes: Configurations in the roadmaps.
        refinement_rounds: Rounds of refinement and search to plan with.
        betas: Trade-offs to plan at.
        seeds: Seeds to plan with.
        arms: Which arms, planar_2r or planar_3r.
    """
    for name in arms:
        if name not in _ARMS:
            raise OptionError(f"arm '{name}' not found; arms are {', '.join(_ARMS)}.")
    settings = itertools.product(arms, betas, nodes, refinement_rounds, seeds)
    rows = [bench.make_settings("arm beta nodes rounds seed", *each) for each in settings]
    return bench.run_bench(BENCH, out, [bench.Case((row,), row) for row in rows], partial(_measure, kept={}))


def _measure(row: bench.Row, progress: Progress, kept: dict[tuple, tuple[float, float]]) -> dict[str, Any] | None:
    """The columns of one plan; optima, by arm, beta and scale, are ``kept``."""
    arm = _ARMS[row.arm]
    with tempfile.TemporaryDirectory() as folder:
        request = PlanRequest.from_options(
            robot=arm.robot_in(Path(folder)),
            scene=arm.scene,
            start=arm.start,
            goal=arm.goal,
            beta=row.beta,
            nodes=row.nodes,
            refinement_rounds=row.rounds,
            seed=row.seed,
            collision="coal",
        )
        found = plan(request=request, progress=progress, timing=None)
    if progress.stopped:
        return None
    if found.outcome is not Outcome.SOLVED:
        raise PlannerError(f"{row.arm} has no path on {row.nodes} nodes: give --nodes more.")
    scale = found.roadmap.scale
    case = (row.arm, row.beta) if row.beta == 1.0 else (row.arm, row.beta, scale.w_low, scale.w_high)
    if case not in kept:
        best, error = grid_optimum(arm, row.beta, scale)
        kept[case] = path_cost(arm, row.beta, scale, best), 100.0 * error
    (optimum, error), cost = kept[case], path_cost(arm, row.beta, scale, found.path)
    gaps = [100.0 * (value * scale.joint_length / optimum - 1.0) for _, value in found.curve]
    columns: dict[str, Any] = {"cost": cost, "optimum": optimum, "error": error, "gap": 100.0 * (cost / optimum - 1.0)}
    return columns | {"corners": count_corners(found.path), "curve": " ".join(f"{gap:.4g}" for gap in gaps)}


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """A line per arm, beta, nodes and effort."""
    columns: dict[str, bench.Pick] = {
        "plans": len,
        "optimum": bench.middle("optimum"),
        "its error (%)": bench.most("error"),
        "gap (%)": bench.middle("gap"),
        "largest (%)": bench.most("gap"),
        "corners": bench.middle("corners"),
        "gap falls as": lambda some: f"{fit[0]:.2g} % / rounds^{fit[1]:.2f}" if (fit := fitted_power(some)) else "-",
    }
    return bench.table(rows, ["arm", "beta", "nodes", "rounds"], columns)


def fitted_power(rows: Sequence[bench.Row]) -> tuple[float, float] | None:
    """(c, p) of gap = c rounds^-p, fitted to the logarithms of the median gaps; None for fewer than four rounds."""
    curves = [[float(gap) for gap in row.curve.split()] for row in rows]
    length = min((len(curve) for curve in curves), default=0)
    points = [(k, float(np.median([curve[k] for curve in curves]))) for k in range(1, length)]
    points = [(math.log(k), math.log(gap)) for k, gap in points if gap > 0]
    if len(points) < 4:
        return None
    x, y = np.array(points).T
    slope, level = np.polyfit(x, y, 1)
    return math.exp(level), -float(slope)


def aims(rows: Sequence[bench.Row]) -> tuple[bench.Verdict, ...]:
    """What plans for planar_2r are meant to reach."""
    found = []
    for nodes, limit in _AIMS.items():
        gaps = [row.gap for row in rows if row.arm == "planar_2r" and row.nodes == nodes]
        sentence = f"planar_2r with {nodes} nodes is within {limit:g} % of the optimum."
        found.append(
            bench.tally(sentence, [gap <= limit for gap in gaps], "" if not gaps else f"At most {max(gaps):.2g} %.")
        )
    return tuple(found)


BENCH = bench.Bench("optimum", __doc__, tables, aims)
