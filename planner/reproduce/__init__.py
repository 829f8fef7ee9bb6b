"""The simulations of the paper, with a verdict on each of its sentences (``planner reproduce``)."""
