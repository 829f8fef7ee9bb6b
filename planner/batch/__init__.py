"""Many plans: a row and a folder for each (``planner batch``)."""
