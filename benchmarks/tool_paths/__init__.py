"""``benchmarks tool-paths``: rasters, lines and circles, followed and judged."""
