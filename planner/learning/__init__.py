"""Learning the weights of eq. (wb) from the field that is computed on them: the paper's learning-based path planning.

    network = learning.untrained(tails, heads, sources, n)
    stages = learning.learn(network, learning.ErrorDriven(), distances, iterations=6)
    path = stages[-1].path(start)

These modules know graphs only; :mod:`planner.learning.roadmap_costs` is the one that knows a roadmap.
"""

from planner.learning.executions import Execution, execute, run_executions
from planner.learning.large_k import K_for_excess, excess_bound, log_cost, sufficient_K
from planner.learning.rules import ErrorDriven, Hebbian, LearningRule
from planner.learning.stages import (
    FIRST_STATE,
    FIRST_WEIGHT,
    Stage,
    learn,
    learn_in_turn,
    next_stage,
    planning_stage,
    trained,
    untrained,
)

__all__ = [
    "FIRST_STATE",
    "FIRST_WEIGHT",
    "ErrorDriven",
    "Execution",
    "Hebbian",
    "K_for_excess",
    "LearningRule",
    "Stage",
    "excess_bound",
    "execute",
    "learn",
    "learn_in_turn",
    "log_cost",
    "next_stage",
    "planning_stage",
    "run_executions",
    "sufficient_K",
    "trained",
    "untrained",
]
