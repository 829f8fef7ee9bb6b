"""Planning in a world that changes. Start with :mod:`planner.session.session`."""
