"""One seed of the manipulator study."""

from __future__ import annotations

import numpy as np

from planner.roadmap.ompl_planners import JointSpace, TreePlanners


def test_no_shortcuts_means_none() -> None:
    """OMPL itself reads 0 attempts as a number of its own."""
    space = JointSpace(np.zeros(2), np.ones(2), np.zeros(2, dtype=bool))
    path = np.array([[0.0, 0.0], [0.5, 0.9], [0.9, 0.1], [1.0, 1.0]])
    with TreePlanners(space, lambda start, delta: True) as planners:
        assert np.array_equal(planners.shorten(path, 0), path)
        assert not np.array_equal(planners.shorten(path, 50), path)
