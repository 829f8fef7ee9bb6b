"""``python -m reproduce learning``: the section on learning-based path planning on many random graphs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial

import numpy as np

from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.gabf.learning import FIRST_WEIGHT, LearningRule
from reproduce.figures import Figure, learned_paths, share_curves
from reproduce.learning.claims import DRAWN, FIELD, IN_TURN, KERNEL, RULE, simulation
from reproduce.learning.graphs import OFFSET, RANGE, SIDE_NODES
from reproduce.learning.study import ERROR_DRIVEN, RULES, T_P, GraphStudy, study_graph
from reproduce.report import Report, Row, collect, judge
from reproduce.verdict import Verdict

SHOWN = (1, 3, 6)
"""Training iterations whose paths are drawn, as in fig. (learning)."""


def run_learning(
    graphs: int = 100, iterations: int = 6, seed: int = 0, jobs: int = 1, progress: Progress = QUIET
) -> Report:
    """Both rules on ``graphs`` connected random graphs for ``iterations``.

    Graph k of a seed does not depend on ``graphs``. Once ``progress`` is stopped the report covers the complete graphs,
    and its ``complete`` is False. Raises OptionError for fewer than one graph or iteration.
    """
    if iterations < 1:
        raise OptionError(f"iterations must be at least 1, got {iterations}.")
    studies = collect(partial(study_graph, iterations=iterations, seed=seed), graphs, jobs, "graphs", progress)
    share = {rule.name: shares(studies, rule) for rule in RULES}
    config = {"graphs": graphs, "iterations": iterations, "seed": seed, "nodes": SIDE_NODES**2, "offset": OFFSET}
    return Report(
        name="learning",
        config=config | {"range": RANGE, "first_weight": FIRST_WEIGHT, "T_p_s": T_P},
        table=tuple(row for rule in RULES for row in _rows(studies, rule)),
        verdicts=learning_verdicts(studies, iterations) if studies else (),
        figures=learning_figures(studies) if studies else {},
        more={
            "graphs": len(studies),
            "share": {name: values[1:] for name, values in share.items()},
            "share_before": {name: values[:1] for name, values in share.items()},
            "parameters": {rule.name: asdict(rule) for rule in RULES},
            "in_turn": [asdict(study.in_turn) for study in studies if study.in_turn],
            "stages": [
                {"graph": k, "rule": name, **asdict(facts)}
                for k, study in enumerate(studies)
                for name, course in study.facts.items()
                for facts in course
            ],
        },
        complete=len(studies) == graphs,
    )


def learning_verdicts(studies: Sequence[GraphStudy], iterations: int) -> tuple[Verdict, ...]:
    """A verdict on every sentence of the section."""
    return (
        *judge(KERNEL, [2.0]),
        *judge((*FIELD, *RULE), studies),
        *judge(IN_TURN, [study for study in studies if study.in_turn]),
        *judge([claim for rule in RULES for claim in simulation(rule, iterations)], studies),
        *judge(DRAWN, [drawn for study in studies for drawn in (*[False] * study.graph.redraws, True)]),
    )


def shares(studies: Sequence[GraphStudy], rule: LearningRule) -> list[float]:
    """The share of graphs with the shortest path, before the first and after each training iteration."""
    courses = [[facts.optimal for facts in study.facts[rule.name]] for study in studies]
    return np.array(courses, dtype=float).mean(axis=0).tolist() if courses else []


def learning_figures(studies: Sequence[GraphStudy]) -> dict[str, Figure]:
    """Every figure by its file name."""
    study = most_telling(studies)
    chosen = [k for k in SHOWN if k < len(study.stages[ERROR_DRIVEN.name])]
    runs = {rule.label.split(",")[0]: [study.stages[rule.name][k] for k in chosen] for rule in RULES}
    curves = {rule.label: shares(studies, rule) for rule in RULES}
    return {
        "learning_paths.png": learned_paths(runs, study.graph.position, study.graph.shortest),
        "learning_share.png": share_curves(curves, len(studies)),
    }


def most_telling(studies: Sequence[GraphStudy]) -> GraphStudy:
    """The graph whose training is most like the paper's figure under the error-driven rule.

    Graphs whose path is shorter after iteration 3 than after iteration 1 and still not the shortest one come first; of
    them the one with the longest path after iteration 1.
    """

    def likeness(study: GraphStudy) -> tuple[bool, float]:
        facts = study.facts[ERROR_DRIVEN.name]
        first, third = (facts[min(k, len(facts) - 1)].excess for k in SHOWN[:2])
        return first > third > 0.0, first

    return max(studies, key=likeness)


def _rows(studies: Sequence[GraphStudy], rule: LearningRule) -> list[Row]:
    """A line per training iteration: the share of optimal paths, and by how much (%) paths are too long."""
    return [
        {
            "rule": rule.name,
            "iteration": k,
            "optimal": float(np.mean([facts.optimal for facts in course])),
            "mean excess (%)": float(np.mean([100.0 * facts.excess for facts in course])),
            "largest excess (%)": max(100.0 * facts.excess for facts in course),
        }
        for k, course in enumerate(zip(*(study.facts[rule.name] for study in studies), strict=True))
    ]
