"""What we claim, measured: ``python -m benchmarks NAME``. Beside the package, not in it; uses its public rooms."""
