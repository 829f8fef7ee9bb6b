"""``benchmarks agreement``: FCL against coal on random states."""
