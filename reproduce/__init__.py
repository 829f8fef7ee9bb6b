"""The simulations of the paper: figures, tables, and a verdict on each of its sentences."""
