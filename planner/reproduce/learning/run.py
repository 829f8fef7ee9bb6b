"""``planner reproduce learning``: the section on learning-based path planning, and its use on a robot's roadmap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np

from planner.base.progress import QUIET, Progress
from planner.learning import FIRST_WEIGHT, LearningRule
from planner.problem.request import SERIAL, WorkersRequest, require_seed
from planner.processes.parallel import collected
from planner.reproduce.learning.graphs import OFFSET, RANGE, SIDE_NODES
from planner.reproduce.learning.robot import (
    Campaign,
    RobotSettings,
    campaign_records,
    campaigns_in,
    learning_row,
    robot_rows,
    robot_verdicts,
    run_campaigns,
)
from planner.reproduce.learning.scan import TRIALS, Tried, scan
from planner.reproduce.learning.study import RULES, T_P, GraphStudy, study_graph
from planner.reproduce.learning.verdicts import learning_verdicts, shares
from planner.reproduce.report import Report, Row, require_counts, require_figures

REASON = (
    "Chosen on graphs that are not among the reported ones (scan). error_driven: alpha 5 is the smallest rate tried "
    "that has the shortest path on all of them by iteration 6, so that the activities still decide what is learned "
    "when; beta 0.001 is 1 / K with K above the smallest sufficient K of the graphs: a larger beta loses those whose "
    "two shortest paths are nearly equal. hebbian: no pair comes near; alpha 0.2, beta 3 is among the best after "
    "iteration 6, where larger alphas have brought the weights to their ceiling."
)


def run_learning(
    graphs: int = 100,
    iterations: int = 6,
    seed: int = 0,
    robot: RobotSettings | None = None,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> Report:
    """Both rules on ``graphs`` connected random graphs for ``iterations``; then, if given, the ``robot``'s roadmaps.

    Graph k of a seed is the same however many are drawn. Once it is asked to stop the report comes back over what is
    whole, with ``complete`` False. Raises OptionError for fewer than one graph or iteration, PlannerError for an
    unusable robot or scene, FileError where matplotlib is missing.
    """
    require_counts(graphs=graphs, iterations=iterations)
    require_seed(seed)
    require_figures()
    campaigns = run_campaigns(robot, seed, progress, workers) if robot else []
    on_graph = partial(_on_graph, iterations=iterations, seed=seed)
    studies = collected(range(graphs), on_graph, workers, "graphs", progress)
    tried = scan(iterations, seed, progress)
    whole = len(studies) == graphs and len(tried) == TRIALS and len(campaigns) == campaigns_in(robot)
    config = {"graphs": graphs, "iterations": iterations, "seed": seed, "nodes": SIDE_NODES**2, "offset": OFFSET}
    config |= {"range": RANGE, "first_weight": FIRST_WEIGHT, "T_p_s": T_P, "robot": asdict(robot) if robot else None}
    return learning_report(studies, tried, campaigns, config, complete=whole)


def _on_graph(k: int, _: Progress, iterations: int, seed: int) -> GraphStudy:
    return study_graph(k, iterations, seed)


def learning_report(
    studies: Sequence[GraphStudy],
    tried: list[Tried],
    campaigns: list[Campaign],
    config: dict[str, Any],
    complete: bool = True,
) -> Report:
    """Table, verdicts and figures of what was measured."""
    from planner.reproduce.learning.figures import learning_pictures

    share = {rule.name: shares(studies, rule) for rule in RULES}
    return Report(
        name="learning",
        config=config,
        table=(*learning_table(studies), *robot_rows(campaigns, config["robot"])),
        verdicts=(*learning_verdicts(studies), *robot_verdicts(campaigns)),
        figures=learning_pictures(studies, tried, campaigns),
        more={
            "graphs": len(studies),
            "share": {name: values[1:] for name, values in share.items()},
            "share_before": {name: values[:1] for name, values in share.items()},
            "parameters": {**{rule.name: asdict(rule) for rule in RULES}, "reason": REASON},
            "scan": [{"rule": t.rule.name, **asdict(t.rule), "share": list(t.share)} for t in tried],
            "thresholds": [asdict(study.threshold) for study in studies],
            "in_turn": [asdict(study.in_turn) for study in studies if study.in_turn],
            "stages": [_flat(k, study, rule) for k, study in enumerate(studies) for rule in RULES],
            "robot": campaign_records(campaigns),
        },
        complete=complete,
    )


def learning_table(studies: Sequence[GraphStudy]) -> list[Row]:
    """One line a rule and training iteration: the share of optimal paths, and how much longer the others are."""
    rows = []
    for rule in RULES:
        for k, facts in enumerate(zip(*(study.facts(rule) for study in studies), strict=True)):
            optimal, excess = np.mean([f.optimal for f in facts]), [100.0 * f.excess for f in facts]
            about = f"{len(studies)} graphs, {rule.name}"
            rows.append(learning_row(about, k, optimal, np.mean(excess), max(excess)))
    return rows


def _flat(k: int, study: GraphStudy, rule: LearningRule) -> Row:
    """The training of one rule on one graph, quantity by quantity."""
    facts = study.facts(rule)
    return {"graph": k, "rule": rule.name, **{name: [getattr(f, name) for f in facts] for name in vars(facts[0])}}
