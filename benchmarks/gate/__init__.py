"""``benchmarks gate``: verdicts on chunks, how long they take, which are refused without need, and none that is wrong."""
