"""One plan: its path, motion, record and files. Read :mod:`planner.planning.plan` first."""
