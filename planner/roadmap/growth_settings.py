"""How roadmaps grow; on its own, so that a kept roadmap is asked without loading what grows one."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class GrowthSettings:
    """How far a tree steps and how long it tries; counts, never clocks, so that a run can be repeated.

    ``range`` (rad): longer steps cross free space sooner, shorter ones enter narrow passages. ``join_motions``: motions
    that the search for a first path may check before it gives up, 8000 per joint where left out; ``shortcuts``: how
    often partial shortcuts of that path are tried. ``motions_per_node``: motions that RRT may check for each node it is
    to add. ``floor``: manipulability w that all motions keep above, but for those that lead up to it from a start or
    goal below; 0 for none.
    """

    range: float = 0.8
    join_motions: int | None = None
    shortcuts: int = 16
    motions_per_node: int = 20
    floor: float = 0.0
