"""The exact trade-off between manipulability and distance on one roadmap. Start with :func:`sweep`."""

from planner.tradeoff.nondominated import Front
from planner.tradeoff.sweep import Checkpoint, Interval, Tradeoff, reached_by_beta, sweep

__all__ = ["Checkpoint", "Front", "Interval", "Tradeoff", "reached_by_beta", "sweep"]
