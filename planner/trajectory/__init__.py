"""Motions in time along a path: limits, time parametrization, proofs of the curve, files for controllers."""
