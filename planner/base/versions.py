"""Versions of the software that results come from."""

from __future__ import annotations

import importlib.metadata
import platform
from functools import cache

__version__ = importlib.metadata.version("gabf-planner")
# what a plan's numbers depend on; the C library gives the last bits of a sine
DECISIVE = ("gabf-planner", "ompl", "pin", "python-fcl", "coal", "numpy", "python", "libc", "machine")


def versions(packages: tuple[str, ...] = DECISIVE) -> dict[str, str]:
    """Installed versions of ``packages``; "python", "libc" and "machine" are the interpreter's and below it."""
    return {name: _version(name) for name in packages}


@cache
def _version(name: str) -> str:
    match name:
        case "python":
            return platform.python_version()
        case "libc":
            return " ".join(platform.libc_ver())
        case "machine":
            return platform.machine()
    return importlib.metadata.version(name)
