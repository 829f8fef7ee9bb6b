"""``benchmarks tables``: ours beside published numbers, with their sources and what differs."""
