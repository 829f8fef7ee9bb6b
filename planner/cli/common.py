"""What the commands share: when the process began, and the kind of a flag."""

from __future__ import annotations

import time
from collections.abc import Callable

import tyro

STARTED = time.perf_counter()

Flag = tyro.conf.FlagCreatePairsOff[bool]


def page_timings(imported: float, write: Callable[[], None]) -> dict[str, float]:
    """Write a page, and tell the seconds of what only a command knows: imports, the page, and all since the start."""
    begin = time.perf_counter()
    write()
    now = time.perf_counter()
    return {"import": imported, "page": now - begin, "total": now - STARTED}
