"""``benchmarks partition|stale``: the dynamics on blocks: what it costs, and what old values do to it."""
