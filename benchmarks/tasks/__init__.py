"""``benchmarks tasks``: something taken and put elsewhere, chosen together against one choice after the other."""
