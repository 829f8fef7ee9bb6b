"""The memory that this process holds, and the most it has held."""

from __future__ import annotations

import resource
import sys
from pathlib import Path


def peak_memory() -> float:
    """The most memory (MiB) this process has held so far.

    Linux's VmHWM, since ru_maxrss counts what the parent held before this program was loaded into the process.
    """
    status = _read_status("VmHWM:")
    if status is not None:
        return status
    per_unit = 2**20 if sys.platform == "darwin" else 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / per_unit


def _read_status(name: str) -> float | None:
    """A line of /proc/self/status, MiB; None where there is none."""
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.exists() else []
    return next((int(line.split()[1]) / 1024.0 for line in lines if line.startswith(name)), None)
