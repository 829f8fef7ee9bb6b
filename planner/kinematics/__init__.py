"""Kinematics of an arm without obstacles: forward, inverse, manipulability."""
