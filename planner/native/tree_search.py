"""The compiled search for a path of motions that look free, by two trees."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from planner.base.arrays import Bools, Floats
from planner.native.loading import address as _at
from planner.native.loading import flags as _bytes
from planner.native.loading import floats as _floats
from planner.native.loading import library as _library
from planner.native.world import NativeBounds, NativeWorld


class SearchSpace(NamedTuple):
    """Where states are drawn and which may be taken; angles rad.

    ``lower``, ``upper`` (dof,) of the box that is drawn from; joints that ``wraps`` (dof,) says have angles from -pi to
    pi. No state is farther from the nearest start and the nearest goal than ``longest`` in all. Along motions
    manipulability, of a ``tool`` as in :meth:`NativeChain.manipulability` (joint, point, rows), is not below ``floor``
    in states that are ``floor_apart`` apart.
    """

    lower: Floats
    upper: Floats
    wraps: Bools
    longest: float
    tool: tuple[int, Floats, int]
    floor: float
    floor_apart: float


def tree_path(
    world: NativeWorld,
    bounds: NativeBounds,
    space: SearchSpace,
    starts: Floats,
    goals: Floats,
    step: float,
    look_apart: float,
    seed: int,
    limit: int,
) -> tuple[Floats | None, int]:
    """A path (k, dof) from one of ``starts`` (s, dof) to one of ``goals`` (g, dof), and how many motions it looked at.

    RRTConnect (Kuffner and LaValle 2000) with steps of ``step`` (rad), whose smaller tree grows, with dynamic domains
    (Yershova et al. 2005). Motions are looked at as :meth:`NativeWorld.look` says, ``look_apart`` (m), and proven
    nowhere. None after ``limit`` motions, or when a stop is asked for. The same ``seed`` gives the same path.
    """
    dof, states, looked_at = world.dof, np.empty((limit + 2, world.dof)), np.zeros(1, dtype=np.int64)
    joint, point, rows = space.tool
    arrays = _floats(space.lower, dof), _floats(space.upper, dof), _bytes(space.wraps, dof), _floats(point, 3)
    lower, upper, wraps, point = arrays
    numbers = np.array([space.longest, space.floor, space.floor_apart, look_apart, step])
    starts, goals = _floats(starts, len(starts), dof), _floats(goals, len(goals), dof)
    reach, body_reach, _ = bounds.addresses
    count = _library.world_tree_path(
        world.handle, reach, body_reach, _at(lower), _at(upper), _at(wraps), joint, _at(point), rows, _at(numbers),
        len(starts), _at(starts), len(goals), _at(goals), seed, limit, _at(states), _at(looked_at),
    )  # fmt: skip
    return states[:count].copy() if count else None, int(looked_at[0])
