"""Certificates: what they cost, and whether one that is false is ever accepted."""
