"""What joint_trajectory_controller makes of the points of a message, written anew with scipy's polynomials."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.interpolate import BPoly

from planner.base.arrays import Floats

Point = tuple[int, Sequence[Floats]]  # nanoseconds from the start; position, velocity, acceleration as far as given


def follow(points: Sequence[Point], state: Sequence[Floats], times: Floats) -> Floats:
    """Return positions (n, dof) at ``times`` (n,) s of a robot that starts at ``state``, and rests at the end.

    Between two points the polynomial takes the derivatives that both have. A first point at 0 replaces the state.
    """
    rows = list(points) if points[0][0] == 0 else [(0, state), *points]
    positions = np.tile(rows[-1][1][0], (len(times), 1))
    for (begin, first), (end, second) in pairwise(rows):
        order, inside = min(len(first), len(second)), (times >= begin * 1e-9) & (times < end * 1e-9)
        for joint in range(len(first[0])):
            ends = [[row[k][joint] for k in range(order)] for row in (first, second)]
            piece = BPoly.from_derivatives([0.0, (end - begin) * 1e-9], ends)
            positions[inside, joint] = piece(times[inside] - begin * 1e-9)
    return positions
