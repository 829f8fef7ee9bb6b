"""Other planners: in this environment (OMPL, toppra) and in environments of their own."""
