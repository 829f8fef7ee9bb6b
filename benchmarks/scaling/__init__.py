"""``benchmarks scaling``: how batches scale with workers, measured and by a model."""
