"""The exact trade-off of manipulability and distance. Start with :mod:`planner.tradeoff.sweep`."""
