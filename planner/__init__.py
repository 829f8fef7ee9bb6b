"""Singularity-averse path planning for robot arms.

The public names below are resolved on first use, so that importing the package, or only
:mod:`planner.gabf`, loads no robot library.
"""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from planner import gabf
    from planner.base.errors import PlannerError
    from planner.base.outcome import Outcome
    from planner.base.request import PlanRequest, SweepRequest
    from planner.collision import make_checker
    from planner.costs.network import build_network
    from planner.gabf.routes import paths_from
    from planner.planning import Plan, plan
    from planner.roadmap.build import build_roadmap
    from planner.roadmap.storage import load_roadmap, save_roadmap
    from planner.tradeoff.sweep import Tradeoff, sweep
    from planner.view.notebook import show
    from planner.world.robot import Robot
    from planner.world.scene import Scene

__all__ = [
    "Outcome",
    "Plan",
    "PlanRequest",
    "PlannerError",
    "Robot",
    "Scene",
    "SweepRequest",
    "Tradeoff",
    "build_network",
    "build_roadmap",
    "gabf",
    "load_roadmap",
    "make_checker",
    "paths_from",
    "plan",
    "save_roadmap",
    "show",
    "sweep",
]

_HOMES = {
    "Outcome": "planner.base.outcome",
    "Plan": "planner.planning",
    "plan": "planner.planning",
    "PlanRequest": "planner.base.request",
    "PlannerError": "planner.base.errors",
    "Robot": "planner.world.robot",
    "Scene": "planner.world.scene",
    "SweepRequest": "planner.base.request",
    "Tradeoff": "planner.tradeoff.sweep",
    "build_network": "planner.costs.network",
    "build_roadmap": "planner.roadmap.build",
    "load_roadmap": "planner.roadmap.storage",
    "make_checker": "planner.collision",
    "paths_from": "planner.gabf.routes",
    "save_roadmap": "planner.roadmap.storage",
    "show": "planner.view.notebook",
    "sweep": "planner.tradeoff.sweep",
}


def __getattr__(name: str) -> Any:
    if name == "gabf":
        return importlib.import_module("planner.gabf")
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'planner' has no attribute '{name}'; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    return __all__


def _show_results_in_notebooks() -> None:
    """Within IPython, plans, trade-offs and roadmaps are shown as tables."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if shell is not None:
        importlib.import_module("planner.view.notebook").register(shell)


_show_results_in_notebooks()
