"""``planner batch``: many plans, one row and one folder each."""
