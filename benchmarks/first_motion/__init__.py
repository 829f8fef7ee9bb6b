"""``benchmarks first-motion``: from a problem to a motion, ours beside other planners', each in its own environment."""
