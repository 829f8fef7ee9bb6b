"""What came of a tool path that was to be followed, as a plan holds it."""

from __future__ import annotations

from dataclasses import dataclass

from planner.base.arrays import Floats
from planner.planning.record import ToolPathRecord


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """The record of ``plan.json``, and what a page draws: points (k, 3) m ``wanted``, and (n, 3) m ``reached``."""

    record: ToolPathRecord
    wanted: Floats
    reached: Floats
