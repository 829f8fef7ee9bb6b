"""Figures for papers and notebooks; each function returns a matplotlib figure and shows nothing.

Lines differ by dash and marker as well as by shade, so that a black and white print is readable.
"""

from planner.view.figures.convergence import convergence, error_decay, node_histories
from planner.view.figures.healing import healing_fields
from planner.view.figures.learning import learned_paths
from planner.view.figures.profiles import clearance_bounds, path_profiles
from planner.view.figures.space import configuration_space
from planner.view.figures.tradeoff import cost_envelope, tradeoff_front
from planner.view.figures.workspace import tool_paths

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
