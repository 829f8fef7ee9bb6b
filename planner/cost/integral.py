"""The manipulability cost integrated along straight motions, with as many states as their length asks for."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from planner.base.arrays import Floats, Ints, frozen
from planner.base.resolutions import W_IN_COST, W_STATES_PER_EDGE
from planner.cost.scale import COSTS, CostScale, mean_manipulability_cost
from planner.kinematics.manipulability import manipulability_along
from planner.robot.robot import Robot

_DOUBLED = 2.0 ** np.arange(7)  # on longer motions states are doubled, no more often than this


def w_along(robot: Robot, start: Floats, delta: Floats, length: Floats) -> Iterator[tuple[Ints, Floats]]:
    """w (j, states) along motions from ``start`` by ``delta`` (k, dof), of a ``length`` (k,), by rows (j,) of as many.

    The rows are those of the motions that have equally many states: no farther apart than ``W_IN_COST``, at least
    ``W_STATES_PER_EDGE``, both ends included, and one more than a multiple of what these leave between them; on motions
    of more than 100 rad no more than there.
    """
    intervals = W_STATES_PER_EDGE - 1
    doubled = np.searchsorted(intervals * W_IN_COST * _DOUBLED, length)
    for level in range(int(doubled.max(initial=-1)) + 1):
        rows = np.flatnonzero(doubled == level)
        if len(rows):
            yield rows, manipulability_along(robot, start[rows], delta[rows], _shares(intervals * 2**level))


@lru_cache
def _shares(intervals: int) -> Floats:
    """Of a motion at the ends of so many equal parts of it."""
    return frozen(np.linspace(0.0, 1.0, intervals + 1))


def costs_along(robot: Robot, start: Floats, delta: Floats, scale: CostScale) -> tuple[Floats, Floats]:
    """w (k, W_STATES_PER_EDGE) along motions from ``start`` by ``delta`` (k, dof), and means (k, 3) of the ``COSTS``.

    The means by Simpson's rule: on random motions of 0.5 to 3 rad they are 0.11 % off in the mean and 8.2 % at most
    with "log", 1.2 % and 93 % with "inverse", where a dip of w is narrower than the states are apart. What is said of
    the smallest w along a path is sampled far more finely.
    """
    few, means = np.empty((len(start), W_STATES_PER_EDGE)), np.empty((len(start), len(COSTS)))
    for rows, w in w_along(robot, start, delta, np.linalg.norm(delta, axis=1)):
        few[rows] = w[:, :: (w.shape[1] - 1) // (W_STATES_PER_EDGE - 1)]
        for k, name in enumerate(COSTS):
            means[rows, k] = mean_manipulability_cost(w, scale, name)
    return few, means
