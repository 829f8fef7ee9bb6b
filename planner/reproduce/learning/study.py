"""All measurements on one graph of the learning simulation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planner.learning import LearningRule
from planner.reproduce.learning.cases import (
    ERROR_DRIVEN,
    HEBBIAN,
    RULES,
    InTurn,
    LargeK,
    LawFacts,
    RuleFacts,
    StageFacts,
    TrainingRun,
    compare_in_turn,
    large_k,
    law_facts,
    rule_facts,
    train,
)
from planner.reproduce.learning.graphs import GridGraph, draw_grid
from planner.reproduce.learning.threshold import Threshold, threshold

IN_TURN = 10
"""Graphs on which arcs are also trained one after another, which takes a hundred times as many planning stages."""


@dataclass(frozen=True, eq=False)
class GraphStudy:
    """Everything measured on one graph; ``runs`` by the rule's name, ``in_turn`` on the first few graphs only."""

    graph: GridGraph
    threshold: Threshold
    large_k: LargeK
    runs: dict[str, TrainingRun]
    rule: RuleFacts
    law: LawFacts
    in_turn: InTurn | None

    def facts(self, rule: LearningRule) -> tuple[StageFacts, ...]:
        """The stages of one rule, from before the first training iteration on."""
        return self.runs[rule.name].facts

    @property
    def stages(self) -> list[StageFacts]:
        """All stages of all rules."""
        return [facts for run in self.runs.values() for facts in run.facts]

    @property
    def trained(self) -> list[StageFacts]:
        """The stages after a training iteration."""
        return [facts for facts in self.stages if facts.iteration > 0]

    def always(self, holds: Callable[[StageFacts], bool]) -> bool:
        """Whether something holds at every stage."""
        return all(map(holds, self.stages))


def study_graph(k: int, iterations: int, seed: int) -> GraphStudy:
    """Everything about graph k of a seed."""
    graph = draw_grid(np.random.default_rng([seed, 0, k]))
    found = threshold(graph)
    runs = {rule.name: train(graph, rule, iterations) for rule in RULES}
    return GraphStudy(
        graph=graph,
        threshold=found,
        large_k=large_k(graph, found),
        runs=runs,
        rule=rule_facts(graph, HEBBIAN, iterations),
        law=law_facts(graph.network),
        in_turn=compare_in_turn(graph, runs[ERROR_DRIVEN.name]) if k < IN_TURN else None,
    )
