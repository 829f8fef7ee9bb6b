"""``benchmarks fuzz``: changed files of every kind load, or are refused with one sentence."""
