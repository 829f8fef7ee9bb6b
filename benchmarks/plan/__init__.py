"""``benchmarks plan``: a folder of planning problems, one row each."""
