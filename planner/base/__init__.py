"""What every room may use: arrays, errors, outcomes, requests, files, progress. Imports nothing of the package."""
