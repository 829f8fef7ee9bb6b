"""Other planners: in this environment (OMPL, toppra, pyroboplan) and in environments of their own."""
