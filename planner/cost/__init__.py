"""Costs of motions: scale, integral along edges, objective."""
