"""Figures for papers and notebooks; each function returns a matplotlib figure and shows nothing.

    planner.figures.motion(plan).savefig("motion.pdf")

Sizes and fonts are those of a journal's column; set_size_inches changes the size. Lines differ by dash and marker as
well as by shade, for black and white prints.
"""

from planner.base.errors import InstallationError

try:
    import matplotlib as matplotlib
except ModuleNotFoundError:
    raise InstallationError(
        "planner.figures needs the Python package matplotlib: run pip install 'gabf-planner[figures]'."
    ) from None

from planner.figures.dynamics import convergence, error_decay
from planner.figures.paths import clearance, manipulability, motion, over_beta, pareto_front
from planner.figures.space import configuration_space
from planner.figures.workspace import roadmap, tool_paths

__all__ = [
    "clearance",
    "configuration_space",
    "convergence",
    "error_decay",
    "manipulability",
    "motion",
    "over_beta",
    "pareto_front",
    "roadmap",
    "tool_paths",
]
