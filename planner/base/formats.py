"""The version of the JSON files that the planner writes, and which of them it reads."""

from __future__ import annotations

from typing import Any

from planner.base.errors import FileError

FORMAT_VERSION = 1  # of plan.json and sweep.json: one more where a key goes or changes its meaning


def require_readable_version(record: dict[str, Any], where: str) -> None:
    """Refuse a record of a later format than this planner knows; one that names none is of version 1."""
    version = record.get("format_version", 1)
    if type(version) is int and 1 <= version <= FORMAT_VERSION:
        return
    raise FileError(
        f"{where} has format version {version!r:.40}, this planner reads up to {FORMAT_VERSION}: "
        "update the planner, or make the file again with this one."
    )
