"""``benchmarks first-path``: the time to a first path, ours beside other planners', each in its own environment."""
