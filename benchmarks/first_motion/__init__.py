"""``benchmarks first-motion``: seconds from a problem to a motion, for our planner and others."""
