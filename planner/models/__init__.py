"""Robots, scenes and shapes as the planner has them, and how plausible they are."""
