"""Section 4.1 of the paper: the control laws on random graphs."""
