"""What every subpackage may use: arrays, errors, outcomes, requests, files, progress. Imports no other subpackage."""
