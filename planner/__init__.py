"""Singularity-averse path planning for robot arms.

The public names below are resolved on first use, so that importing the package, or only
:mod:`planner.gabf`, loads no robot library.
"""

from __future__ import annotations

import importlib
from typing import Any

_PUBLIC: dict[str, str] = {}

__all__ = sorted([*_PUBLIC, "gabf"])


def __getattr__(name: str) -> Any:
    if name == "gabf":
        return importlib.import_module("planner.gabf")
    if name in _PUBLIC:
        return getattr(importlib.import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module 'planner' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
