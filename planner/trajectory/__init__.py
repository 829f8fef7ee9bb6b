"""Motions in time along a path: limits, time laws, proofs, checks, and files for controllers."""
