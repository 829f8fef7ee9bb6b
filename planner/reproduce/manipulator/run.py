"""``planner reproduce manipulator``: section 4.2 on many roadmaps, its numbers beside ours, every sentence judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import lru_cache, partial
from typing import Any

import numpy as np

from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.problem.request import PAPER_NODES, SERIAL, Backend, SweepRequest, WorkersRequest
from planner.processes.parallel import collected
from planner.reproduce.manipulator.case import BETAS, RRT, SHORTENED, MeasuredPath, SeedStudy, label_of, study_seed
from planner.reproduce.manipulator.verdicts import BLUE, PAPER_COSTS, RED, manipulator_verdicts
from planner.reproduce.report import Picture, Report, Row, require_counts, require_figures
from planner.setup.open import Query, make_query

LABELS = (*map(label_of, BETAS), RRT, SHORTENED)
_COLUMNS = {
    **{"manipulability_cost": "omega", "distance_cost": "D", "w_min": "w_min", "w_mean": "w_mean"},
    **{"joint_length": "joint_rad", "workspace_length": "tool_m", "turning": "turning_rad"},
}
"""Measures of a path, and their short names in the table."""


def run_manipulator(
    seeds: int = 10,
    nodes: int = PAPER_NODES,
    collision: Backend = "fcl",
    seed: int = 0,
    strands: float = 0.0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> Report:
    """Section 4.2 on ``seeds`` roadmaps of ``nodes`` nodes, those of ``seed``, ``seed`` + 1, ...; one roadmap per seed.

    All betas and the RRT path share start, goals, roadmap and cost scale. ``strands`` is the share of nodes that come
    from refined best paths: 0 as in the paper, where all are RRT's; ``planner plan`` uses 0.1. ``progress`` is called
    with ("seeds", done, total); once it is asked to stop, the report covers the seeds that are complete, and its
    ``complete`` is False. Raises OptionError for fewer than one seed or a share outside [0, 1], FileError where
    matplotlib is missing.
    """
    require_counts(seeds=seeds)
    if not 0.0 <= strands <= 1.0:
        raise OptionError(f"strands {strands:g} are no share of the nodes: give a number from 0 to 1.")
    require_figures()
    requests = [SweepRequest(nodes=nodes, collision=collision, seed=seed + k) for k in range(seeds)]
    query = _query(requests[0])
    on_seed = partial(_on_seed, first=requests[0], strands=strands)
    cases = collected(requests, on_seed, workers, "seeds", progress)
    return manipulator_report(query, cases, requests[0], seeds, strands)


@lru_cache(1)
def _query(request: SweepRequest) -> Query:
    return make_query(request, near_start=False)


def _on_seed(request: SweepRequest, progress: Progress, first: SweepRequest, strands: float) -> SeedStudy | None:
    """One seed; start and goals are those of the ``first``."""
    return study_seed(_query(first), request, strands, progress=progress)


def manipulator_report(
    query: Query, cases: Sequence[SeedStudy], request: SweepRequest, seeds: int, strands: float = 0.0
) -> Report:
    """Table, verdicts and figures of what was measured."""
    whole = [case for case in cases if case.ways]
    return Report(
        name="manipulator",
        config={
            "seeds": seeds,
            **{name: getattr(request, name) for name in ("nodes", "collision", "seed", "robot", "scene", "law")},
            "strands": strands,
            "prescribed_time_s": request.prescribed_time,
            **{name: getattr(request, name) for name in ("metric", "manipulability_cost")},
        },
        table=tuple(_row(label, whole) for label in LABELS) if whole else (),
        verdicts=manipulator_verdicts(cases, request.prescribed_time),
        figures=manipulator_pictures(query, shown_case(whole), whole) if whole else {},
        more={
            "drawn_seed": shown_case(whole).seed if whole else None,
            "roadmaps": [_facts(case) for case in cases],
            "paths": [_flat(case, path) for case in whole for path in case.ways.values()],
        },
        complete=len(cases) == seeds,
    )


def shown_case(cases: Sequence[SeedStudy]) -> SeedStudy:
    """The case whose paths are drawn: the first whose betas fall into the paper's groups, else with several paths."""
    alike = [case for case in cases if case.groups == (RED, BLUE)]
    several = [case for case in cases if len(case.groups) > 1]
    return (*alike, *several, *cases)[0]


def manipulator_pictures(query: Query, shown: SeedStudy, cases: Sequence[SeedStudy]) -> dict[str, Picture]:
    """Every figure by its file name; tool paths and profiles are those of ``shown``."""
    from planner.figures import figure as draw

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
        "manipulator_tool_paths.png": draw.tool_paths(query.robot, query.scene, paths),
        "manipulator_profiles.png": draw.path_profiles(query.checker, paths),
        "manipulator_costs.png": draw.beta_costs(BETAS, (ours[0], ours[1]), others, (printed[0], printed[1])),
    }


def _row(label: str, cases: Sequence[SeedStudy]) -> Row:
    """One path's medians over the seeds beside the paper's printed costs (no unit); w in m^3."""
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
        "shared": [list(group) for group in case.groups] if case.ways else [],
        "fields": [asdict(field) for field in case.fields],
    }


def _flat(case: SeedStudy, path: MeasuredPath) -> Row:
    scalars = {name: getattr(path, name) for name in _COLUMNS}
    return {"seed": case.seed, "path": path.label, **scalars, "contact": path.contact, "q": path.q.tolist()}
