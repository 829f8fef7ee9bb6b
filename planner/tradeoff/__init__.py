"""The exact trade-off between manipulability and distance on one roadmap. Start with :mod:`planner.tradeoff.sweep`."""
