"""``benchmarks quality``: how good paths are, at several betas and efforts, beside OMPL's planners."""
