"""Versions of the software that results come from."""

from __future__ import annotations

import importlib.metadata
import platform

__version__ = importlib.metadata.version("gabf-planner")
DECISIVE = ("gabf-planner", "ompl", "pin", "python-fcl", "coal", "numpy")  # what a plan's numbers depend on


def versions(packages: tuple[str, ...] = DECISIVE) -> dict[str, str]:
    """Installed versions of ``packages``, "python" meaning the interpreter's."""
    return {name: _version(name) for name in packages}


def _version(name: str) -> str:
    return platform.python_version() if name == "python" else importlib.metadata.version(name)
