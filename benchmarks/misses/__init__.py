"""``benchmarks misses``: thin obstacles, proofs against samples."""
