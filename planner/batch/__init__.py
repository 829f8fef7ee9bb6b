"""Many plans, or one sweep for many seeds: a row and a folder each, kept (``planner batch``, ``sweep --seeds``)."""
