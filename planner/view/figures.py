"""Every figure for notebooks and reports, in one place; functions return a matplotlib figure and show nothing.

Lines are told apart by dash and marker as well as by shade, so that a black and white print is readable.
"""

from planner.view.convergence_figures import convergence, error_decay
from planner.view.law_figures import near_deadline, node_courses
from planner.view.profile_figures import clearance_bounds, path_profiles
from planner.view.space_figures import configuration_space
from planner.view.tradeoff_figures import beta_costs, cost_envelope, tradeoff_front
from planner.view.workspace_figures import tool_paths

__all__ = [
    "beta_costs",
    "clearance_bounds",
    "configuration_space",
    "convergence",
    "cost_envelope",
    "error_decay",
    "near_deadline",
    "node_courses",
    "path_profiles",
    "tool_paths",
    "tradeoff_front",
]
