"""Section 4.2 of the paper: the iiwa 14 among obstacles."""
