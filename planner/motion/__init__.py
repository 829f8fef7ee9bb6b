"""From a proven path to a motion that a robot can run: limits, time laws, proofs of the curve, files."""
