"""``planner bench roadmap``: proven roadmaps and queries against other PRMs."""
