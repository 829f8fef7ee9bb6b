"""Figures for papers and notebooks; each function returns a matplotlib figure and shows nothing.

Lines differ by dash and marker as well as by shade, so that a black and white print is readable.
"""

from planner.view.figures.dynamics import convergence, error_decay, learned_paths, node_histories
from planner.view.figures.paths import clearance_bounds, cost_envelope, path_profiles, tool_paths, tradeoff_front
from planner.view.figures.space import configuration_space, healing_fields

__all__ = [
    "clearance_bounds",
    "configuration_space",
    "convergence",
    "cost_envelope",
    "error_decay",
    "healing_fields",
    "learned_paths",
    "node_histories",
    "path_profiles",
    "tool_paths",
    "tradeoff_front",
]
