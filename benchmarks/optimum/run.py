"""``benchmarks optimum``: planar arms, planned with several seeds, against the optimum of a fine grid."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.bench import run_bench, software
from benchmarks.optimum.arms import ARMS, PlanarArm
from benchmarks.optimum.grid import grid_optimum, path_cost
from benchmarks.optimum.report import Row, to_markdown
from benchmarks.results import Results
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.paths.measure import corners
from planner.planning.plan import plan
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest


@dataclass(frozen=True)
class _Run:
    """One plan."""

    arm: PlanarArm
    beta: float
    nodes: int
    effort: int
    seed: int

    @property
    def key(self) -> tuple[str, float, int, int, int, str]:
        return (self.arm.name, self.beta, self.nodes, self.effort, self.seed, software())


def bench_optimum(
    out: Path,
    nodes: Sequence[int] = (1000, 5000),
    efforts: Sequence[int] = (6, 30),
    betas: Sequence[float] = (0.0, 1.0),
    seeds: Sequence[int] = (0, 1, 2),
    arms: Sequence[str] = ("planar_2r", "planar_3r"),
    progress: Progress = QUIET,
) -> Results[Row]:
    """Every one of ``arms`` at all ``betas``, ``nodes``, ``efforts`` and ``seeds``: the gap to the grid's optimum.

    Writes ``optimum.csv`` and ``optimum.md`` to ``out``; rows that are there already are kept. Raises OptionError for
    an arm that is not there, FileError where the folder cannot be used.
    """
    known = {arm.name: arm for arm in ARMS}
    for name in arms:
        if name not in known:
            raise OptionError(f"arm '{name}' not found; arms are {', '.join(known)}.")
    asked = itertools.product((known[name] for name in arms), betas, nodes, efforts, seeds)
    runs = [_Run(*each) for each in asked]
    kept: dict[tuple, tuple[float, float]] = {}
    return run_bench(
        out,
        "optimum",
        Row,
        runs,
        lambda table, run: table.find(run.key),
        lambda run, progress: _measure(run, kept, progress),
        to_markdown,
        "plans",
        progress,
    )


def _measure(run: _Run, kept: dict[tuple, tuple[float, float]], progress: Progress) -> list[Row]:
    """The row of one plan, none where stopped; optima, by arm, beta and scale, are ``kept``."""
    arm = run.arm
    with tempfile.TemporaryDirectory() as folder:
        request = PlanRequest(
            robot=arm.robot_in(Path(folder)),
            scene=arm.scene,
            start=arm.start,
            goal=arm.goal,
            beta=run.beta,
            nodes=run.nodes,
            effort=run.effort,
            seed=run.seed,
            collision="coal",
        )
        found = plan(request, progress)
    if found.outcome is not Outcome.SOLVED:
        return []
    scale = found.roadmap.scale
    case = (arm.name, run.beta) if run.beta == 1.0 else (arm.name, run.beta, scale.w_low, scale.w_high)
    if case not in kept:
        best, error = grid_optimum(arm, run.beta, scale)
        kept[case] = path_cost(arm, run.beta, scale, best), 100.0 * error
    (optimum, error), cost = kept[case], path_cost(arm, run.beta, scale, found.path)
    gaps = [100.0 * (value * scale.joint_length / optimum - 1.0) for _, value in found.curve]
    curve = " ".join(f"{gap:.4g}" for gap in gaps)
    return [Row(*run.key, cost, optimum, error, 100.0 * (cost / optimum - 1.0), corners(found.path), curve)]
