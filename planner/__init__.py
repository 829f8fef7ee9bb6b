"""Singularity-averse path planning for robot arms.

The public names below are resolved on first use, so that importing the package, or only
:mod:`planner.gabf`, loads no robot library.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from planner import gabf
    from planner.collision import make_checker
    from planner.costs import build_network
    from planner.errors import PlannerError
    from planner.outcome import Outcome
    from planner.plan import Plan, build_roadmap
    from planner.request import PlanRequest
    from planner.robot import Robot
    from planner.scene import Scene

__all__ = [
    "Outcome",
    "Plan",
    "PlanRequest",
    "PlannerError",
    "Robot",
    "Scene",
    "build_network",
    "build_roadmap",
    "gabf",
    "make_checker",
]

_HOMES = {
    "Outcome": "planner.outcome",
    "Plan": "planner.plan",
    "PlanRequest": "planner.request",
    "PlannerError": "planner.errors",
    "Robot": "planner.robot",
    "Scene": "planner.scene",
    "build_network": "planner.costs",
    "build_roadmap": "planner.plan",
    "make_checker": "planner.collision",
}


def __getattr__(name: str) -> Any:
    if name == "gabf":
        return importlib.import_module("planner.gabf")
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'planner' has no attribute '{name}'; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    return __all__
