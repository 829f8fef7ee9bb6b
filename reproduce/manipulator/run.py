"""``python -m reproduce manipulator``: section 4.2 on many roadmaps, with the paper's numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np

from planner.base.progress import QUIET, Progress
from planner.figures.paths import clearance, manipulability
from planner.figures.workspace import tool_paths
from planner.problem.options import PAPER_NODES
from planner.problem.request import SweepRequest
from planner.query.query import Query
from reproduce.figures import Figure, beta_costs
from reproduce.manipulator.case import (
    BETAS,
    BLUE,
    LABELS,
    PAPER_COSTS,
    RED,
    RRT,
    SHORTENED,
    SeedStudy,
    label_of,
    query_of,
    study_seed,
)
from reproduce.manipulator.claims import NETWORK, PATHS, PRINTED
from reproduce.report import Report, Row, collect, judge

_COLUMNS = {
    **{"manipulability_cost": "omega", "distance_cost": "D", "w_min": "w_min", "w_mean": "w_mean"},
    **{"joint_length": "joint_rad", "workspace_length": "tool_m", "turning": "turning_rad"},
}
"""Measures of a path, and their short names in the table."""


def run_manipulator(
    seeds: int = 10, nodes: int = PAPER_NODES, seed: int = 0, jobs: int = 1, progress: Progress = QUIET
) -> Report:
    """Section 4.2 on ``seeds`` roadmaps of ``nodes`` nodes, those of ``seed``, ``seed`` + 1, ...

    All betas and the RRT path share start, goals, roadmap and cost scale. Once ``progress`` is stopped the report
    covers the complete seeds, and its ``complete`` is False. Raises OptionError for fewer than one seed.
    """
    request = SweepRequest.from_options(nodes=nodes, seed=seed)
    cases = collect(partial(study_seed, first=request), seeds, jobs, "seeds", progress)
    whole = [case for case in cases if case.ways]
    asked = ("nodes", "collision", "seed", "robot", "scene", "law", "prescribed_time", "metric", "manipulability_cost")
    return Report(
        name="manipulator",
        config={"seeds": seeds, **{name: value for name, value in request.config().items() if name in asked}},
        table=tuple(_row(label, whole) for label in LABELS) if whole else (),
        verdicts=judge(NETWORK, cases) + judge(PATHS, whole) + judge(PRINTED, [PAPER_COSTS]),
        figures=manipulator_figures(query_of(request), shown_case(whole), whole) if whole else {},
        more={
            "drawn_seed": shown_case(whole).seed if whole else None,
            "roadmaps": [_facts(case) for case in cases],
            "paths": [
                {"seed": case.seed, "path": path.label, "q": path.q, "contact": path.contact}
                | {name: getattr(path, name) for name in _COLUMNS}
                for case in whole
                for path in case.ways.values()
            ],
        },
        complete=len(cases) == seeds,
    )


def shown_case(cases: Sequence[SeedStudy]) -> SeedStudy:
    """The case whose paths are drawn: the first whose betas fall into the paper's groups, else with several paths."""
    alike = [case for case in cases if case.groups == (RED, BLUE)]
    several = [case for case in cases if len(case.groups) > 1]
    return (*alike, *several, *cases)[0]


def manipulator_figures(query: Query, shown: SeedStudy, cases: Sequence[SeedStudy]) -> dict[str, Figure]:
    """Every figure by its file name; tool paths and profiles are those of ``shown``."""
    paths = {"β = " + ", ".join(f"{beta:g}" for beta in betas): shown.way(betas[0]).q for betas in shown.groups}
    paths[RRT] = shown.ways[RRT].q
    omega, distance = (
        {label: np.array([getattr(case.ways[label], name) for case in cases]) for label in LABELS}
        for name in ("manipulability_cost", "distance_cost")
    )
    ours = [np.column_stack([costs[label_of(beta)] for beta in BETAS]) for costs in (omega, distance)]
    printed = np.array([PAPER_COSTS[beta] for beta in BETAS]).T
    others = {label: (omega[label], distance[label]) for label in (RRT, SHORTENED)}
    return {
        "manipulator_tool_paths.png": tool_paths(paths, checker=query.checker),
        "manipulator_w.png": manipulability(paths, checker=query.checker),
        "manipulator_clearance.png": clearance(paths, checker=query.checker),
        "manipulator_costs.png": beta_costs(BETAS, (ours[0], ours[1]), others, (printed[0], printed[1])),
    }


def _row(label: str, cases: Sequence[SeedStudy]) -> Row:
    """One path's medians over the seeds, with the paper's printed costs (no unit); w in m^3."""
    printed = {label_of(beta): costs for beta, costs in PAPER_COSTS.items()}.get(label, (None, None))
    paths = [case.ways[label] for case in cases]
    median = {short: float(np.median([getattr(path, name) for path in paths])) for name, short in _COLUMNS.items()}
    sharp = float(np.median([path.sharp_turns for path in paths]))
    return {"path": label, "paper_omega": printed[0], "paper_D": printed[1], **median, "sharp_turns": sharp}


def _facts(case: SeedStudy) -> dict[str, Any]:
    return {
        "seed": case.seed,
        "nodes": len(case.roadmap.nodes),
        "edges": len(case.roadmap.edges),
        "edges_certified": int(case.roadmap.proven.sum()),
        "sha256": case.roadmap.sha256,
        "solved": bool(case.ways),
        "shared": case.groups if case.ways else (),
        "fields": [asdict(field) for field in case.fields],
    }
