"""Versions of the software that results come from."""

from __future__ import annotations

import hashlib
import importlib.metadata
import platform
from functools import cache
from pathlib import Path

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


@cache
def software(*folders: Path) -> str:
    """Versions, and a hash of the sources of this package and of more ``folders``: rows of other software are stale."""
    digest = hashlib.sha256()
    for folder in (Path(__file__).resolve().parents[1], *folders):
        for path in sorted([*folder.rglob("*.py"), *folder.rglob("*.[ch]pp")]):
            digest.update(f"{path.relative_to(folder)}\0".encode() + path.read_bytes() + b"\0")
    return ", ".join([*(" ".join(item) for item in versions().items()), f"source {digest.hexdigest()[:8]}"])
