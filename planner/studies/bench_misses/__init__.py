"""``planner bench misses``: thin obstacles, proofs against samples."""
