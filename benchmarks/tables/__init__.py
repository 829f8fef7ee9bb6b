"""``benchmarks tables``: published numbers with ours, their sources and differences."""
