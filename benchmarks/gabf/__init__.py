"""``benchmarks gabf``: the dynamics against other integrators and Dijkstra."""
