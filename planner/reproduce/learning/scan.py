"""How the rules' parameters were chosen: a scan on graphs that are not among the reported ones."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from planner import learning
from planner.base.progress import Progress
from planner.learning import ErrorDriven, Hebbian, LearningRule
from planner.reproduce.learning.graphs import START, GridGraph, draw_grid

ALPHAS = (0.05, 0.2, 1.0, 5.0, 20.0)
BETAS = (0.001, 0.1, 1.0, 3.0)
GRAPHS = 20
TRIALS = 2 * len(ALPHAS) * len(BETAS)


@dataclass(frozen=True)
class Tried:
    """One rule with its parameters: the ``share`` of graphs with the shortest path after each training iteration."""

    rule: LearningRule
    share: tuple[float, ...]

    @property
    def last(self) -> float:
        """The share after the last iteration."""
        return self.share[-1]


def scan(iterations: int, seed: int, progress: Progress) -> list[Tried]:
    """Every pair of ``ALPHAS`` and ``BETAS`` for both rules on ``GRAPHS`` graphs, as far as it came."""
    graphs = [draw_grid(np.random.default_rng([seed, 1, k])) for k in range(GRAPHS)]
    found = []
    for kind, alpha, beta in itertools.product((Hebbian, ErrorDriven), ALPHAS, BETAS):
        if progress.stopped:
            break
        rule = kind(alpha=alpha, beta=beta)
        runs = np.array([_optimal(graph, rule, iterations) for graph in graphs])
        found.append(Tried(rule, tuple(runs.mean(axis=0).tolist())))
        progress("parameters", len(found), TRIALS)
    return found


def _optimal(graph: GridGraph, rule: LearningRule, iterations: int) -> list[bool]:
    stages = learning.learn(graph.network, rule, graph.d, iterations)
    return [graph.is_shortest(stage.path(START)) for stage in stages[1:]]
