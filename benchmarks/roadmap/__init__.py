"""``benchmarks roadmap``: proven roadmaps and queries against other PRMs."""
