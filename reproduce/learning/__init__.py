"""Section 4.3 of the paper: weights that are learned while planning."""
