"""Pick and place: one field over all modes chooses grasps, paths and placements together."""
