"""``benchmarks replan``: replanning in a changing world against planning anew; a healing field against D* Lite."""
