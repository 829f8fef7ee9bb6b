"""``planner bench agreement``: FCL against coal on random states."""
