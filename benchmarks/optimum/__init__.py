"""Planar arms: how far plans are from the optimum of a fine grid, whose geometry is computed without the planner."""
