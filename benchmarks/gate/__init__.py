"""``benchmarks gate``: how long verdicts take, which are refused without need, and that none is wrong."""
