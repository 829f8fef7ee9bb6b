"""The figures of the learning simulations, from what was measured: which runs go into which picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planner.figures import learning as learning_figures
from planner.figures.learning import CurvePanel, GraphPanel
from planner.learning import LearningRule
from planner.reproduce.learning.graphs import START
from planner.reproduce.learning.robot import PRIORS, TASKS, Campaign, regrets
from planner.reproduce.learning.scan import ALPHAS, BETAS, GRAPHS, Tried
from planner.reproduce.learning.study import ERROR_DRIVEN, RULES, GraphStudy
from planner.reproduce.learning.verdicts import shares
from planner.reproduce.report import Picture

SHOWN = (1, 3, 6)
"""Training iterations whose paths are drawn, as in fig. (learning)."""

_FIRST = 20
_WINDOW = 10


def learning_pictures(
    studies: Sequence[GraphStudy], tried: Sequence[Tried], campaigns: Sequence[Campaign]
) -> dict[str, Picture]:
    """Every figure by its file name, as far as there is something to draw."""
    figures: dict[str, Picture] = {}
    if studies:
        figures["learning_paths.png"] = paths_figure(most_telling(studies))
        figures["learning_share.png"] = share_figure(studies)
        figures["learning_threshold.png"] = threshold_figure(studies)
    if tried:
        figures["learning_scan.png"] = scan_figure(tried)
    if campaigns:
        figures["learning_robot.png"] = robot_figure(campaigns)
    return figures


def most_telling(studies: Sequence[GraphStudy]) -> GraphStudy:
    """The graph whose training is most like the paper's figure under the error-driven rule.

    Those come first whose path is shorter after iteration 3 than after iteration 1 and still not the shortest one, and
    among them the one that is furthest off after iteration 1.
    """

    def likeness(study: GraphStudy) -> tuple[bool, float]:
        facts = study.facts(ERROR_DRIVEN)
        first, third = (facts[min(k, len(facts) - 1)].excess for k in SHOWN[:2])
        return first > third > 0.0, first

    return max(studies, key=likeness)


def paths_figure(study: GraphStudy, rules: Sequence[LearningRule] = RULES) -> Picture:
    """Fig. (learning) on one graph, a row for each rule."""
    return learning_figures.learned_paths([_panels(study, rule) for rule in rules])


def share_figure(studies: Sequence[GraphStudy]) -> Picture:
    """Share of shortest paths by iteration."""
    return learning_figures.share_curves({rule.label: shares(studies, rule) for rule in RULES}, len(studies))


def threshold_figure(studies: Sequence[GraphStudy]) -> Picture:
    """Smallest K and proved bound."""
    columns = [np.array([getattr(s.threshold, name) for s in studies]) for name in ("gap", "smallest", "bound")]
    return learning_figures.threshold_scatter(*columns, used=1.0 / ERROR_DRIVEN.beta)


def scan_figure(tried: Sequence[Tried]) -> Picture:
    """Share after the last iteration over alpha and beta."""
    grids = {}
    for kind in RULES:
        grid = np.full((len(ALPHAS), len(BETAS)), np.nan)
        for t in tried:
            if t.rule.name == kind.name:
                grid[ALPHAS.index(t.rule.alpha), BETAS.index(t.rule.beta)] = t.last
        grids[_name(kind)] = grid
    return learning_figures.scan_maps(ALPHAS, BETAS, grids, GRAPHS)


def robot_figure(campaigns: Sequence[Campaign]) -> Picture:
    """Regret and beliefs against executions, for one start and for many."""
    one, many = TASKS
    regret, believed = "regret (optimal costs)", "cost believed / optimum"

    def grab(task: str, quantity: str) -> dict[str, np.ndarray]:
        return {prior: regrets(campaigns, task, prior, quantity) for prior in PRIORS}

    spread_out = grab(many, "field_regret")
    return learning_figures.execution_curves(
        [
            CurvePanel("one start: path executed", regret, grab(one, "regret"), band=True, level=0.0, last=_FIRST),
            CurvePanel("one start: cost believed", believed, grab(one, "estimate"), band=True, level=1.0, last=_FIRST),
            CurvePanel(
                f"many starts: paths executed, {_WINDOW} a mark", regret, grab(many, "regret"), _WINDOW, level=0.0
            ),
            CurvePanel("many starts: paths from every node", f"mean {regret}", spread_out, band=True, level=0.0),
        ]
    )


def _name(rule: LearningRule) -> str:
    """The rule without its parameters."""
    return rule.label.split(",")[0]


def _panels(study: GraphStudy, rule: LearningRule) -> list[GraphPanel]:
    run, graph = study.runs[rule.name], study.graph
    last = len(run.stages) - 1
    chosen = [*(k for k in SHOWN if k < last), last]
    arcs = np.column_stack([graph.network.tails, graph.network.indices])
    return [
        GraphPanel(
            title=f"{_name(rule)}, iteration {k}\n"
            + ("shortest path" if run.facts[k].optimal else f"{100 * run.facts[k].excess:.1f} % too long"),
            position=graph.position,
            arcs=arcs,
            wbar=run.stages[k].wbar,
            path=run.stages[k].path(START),
            shortest=graph.shortest,
        )
        for k in chosen
    ]
