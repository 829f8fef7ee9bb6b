"""How one of many plans ended."""

from __future__ import annotations

SOLVED, NO_PATH, REFUSED, TIMED_OUT, CRASHED = "solved", "no_path", "refused", "timed out", "crashed"
