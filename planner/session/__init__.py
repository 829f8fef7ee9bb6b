"""A world that changes: robot, scene and roadmap that live together. Start with :mod:`planner.session.session`."""
