"""Figures for notebooks and reports. The door to matplotlib; functions return the figure and show nothing."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from planner.errors import OptionError
from planner.path import dense_path, path_manipulability
from planner.plan import Plan

# told apart by dash as well as by shade, so that a black and white print is readable
_STYLES = ("-", "--", "-.", ":")
_SHADES = ("#12355b", "#c1440e", "#3a7d44", "#7a5195", "#8a6d00")


def manipulability_profile(plans: Mapping[str, Plan]) -> Figure:
    """w along each plan's path against the joint motion so far (rad); ``plans`` by the label they get.

    Raises :class:`OptionError` where a plan has no path.
    """
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    axes = figure.add_subplot()
    for k, (label, plan) in enumerate(plans.items()):
        if not len(plan.path):
            raise OptionError(f"plan '{label}' has no path to draw: its outcome is '{plan.outcome.key}'.")
        q = dense_path(plan.path)
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))])
        w = path_manipulability(plan.robot, plan.path)
        axes.plot(along, w, _STYLES[k % 4], color=_SHADES[k % 5], label=label, linewidth=1.6)
    axes.set_xlabel("joint motion from the start (rad)")
    axes.set_ylabel("manipulability w")
    axes.set_ylim(bottom=0.0)
    axes.margins(x=0.01)
    axes.grid(alpha=0.25)
    axes.legend(frameon=False)
    return figure
