"""The figures of section 4.2, from what was measured: which paths go into which picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planner.base.arrays import Floats
from planner.figures.figure import beta_costs, path_profiles, tool_paths
from planner.reproduce.manipulator.case import BETAS, RRT, SHORTENED, SeedStudy, label_of
from planner.reproduce.manipulator.verdicts import PAPER_COSTS
from planner.reproduce.report import Picture
from planner.setup.open import Query


def manipulator_pictures(query: Query, shown: SeedStudy, cases: Sequence[SeedStudy]) -> dict[str, Picture]:
    """Every figure by its file name; tool paths and profiles are those of ``shown``."""
    paths = {_label(betas): shown.ways[label_of(betas[0])].q for betas in shown.groups}
    paths[RRT] = shown.ways[RRT].q
    return {
        "manipulator_tool_paths.png": tool_paths(query.robot, query.scene, paths),
        "manipulator_profiles.png": path_profiles(query.checker, paths),
        "manipulator_costs.png": _cost_figure(cases),
    }


def _label(betas: Sequence[float]) -> str:
    return "β = " + ", ".join(f"{beta:g}" for beta in betas)


def _cost_figure(cases: Sequence[SeedStudy]) -> Picture:
    costs = [_costs(cases, label_of(beta)) for beta in BETAS]
    ours = np.column_stack([omega for omega, _ in costs]), np.column_stack([distance for _, distance in costs])
    printed = np.array([PAPER_COSTS[beta] for beta in BETAS]).T
    others = {label: _costs(cases, label) for label in (RRT, SHORTENED)}
    return beta_costs(BETAS, ours, others, (printed[0], printed[1]))


def _costs(cases: Sequence[SeedStudy], label: str) -> tuple[Floats, Floats]:
    """Omega and D (seeds,) of one path."""
    paths = [case.ways[label] for case in cases]
    return np.array([path.manipulability_cost for path in paths]), np.array([path.distance_cost for path in paths])
