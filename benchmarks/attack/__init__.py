"""``benchmarks attack``: an optimiser against every claim that proofs rest on."""
