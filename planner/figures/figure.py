"""Every figure for notebooks and reports, in one place; functions return a matplotlib figure and show nothing.

Lines are told apart by dash and marker as well as by shade, so that a black and white print is readable.
"""

from planner.figures.convergence import convergence, error_decay
from planner.figures.healing import healing_fields
from planner.figures.laws import near_deadline, node_histories
from planner.figures.profiles import clearance_bounds, path_profiles
from planner.figures.space import configuration_space
from planner.figures.tradeoff import beta_costs, cost_envelope, tradeoff_front
from planner.figures.workspace import tool_paths

__all__ = [
    "beta_costs",
    "clearance_bounds",
    "configuration_space",
    "convergence",
    "cost_envelope",
    "error_decay",
    "healing_fields",
    "near_deadline",
    "node_histories",
    "path_profiles",
    "tool_paths",
    "tradeoff_front",
]
