"""Measurements of our claims: ``python -m benchmarks NAME``. The package does not contain them."""
