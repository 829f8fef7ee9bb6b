"""The blocks of clouds that come near a body, for a second look at these alone.

No tree of a proof takes part, so its fault cannot hide a sample from both.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, column_bounds
from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.clouds import Points, group_samples
from planner.robot.shapes import bounding_box

_SIDE = 0.25  # m: trees of larger blocks hold more than the samples near a link


class Blocks(NamedTuple):
    """Samples of a cloud by the cells of a grid, and the middles and half sizes (m, 3) of their boxes."""

    samples: list[Floats]
    middles: Floats
    halves: Floats


@lru_cache(maxsize=1024)
def blocks_of(cloud: Points) -> Blocks:
    """Return the blocks of a cloud."""
    samples = group_samples(cloud, _SIDE)[1]
    boxes = np.array([column_bounds(part) for part in samples])
    return Blocks(samples, boxes.mean(axis=1), 0.5 * (boxes[:, 1] - boxes[:, 0]))


class NearBlocks(NamedTuple):
    """Blocks (k,) of the cloud of a ``pair`` that its body comes near in configurations ``rows`` (k,).

    The body stands there at ``turns`` (k, 3, 3) and ``shifts`` (k, 3) in the frame of the cloud.
    """

    pair: int
    rows: Ints
    blocks: Ints
    turns: Floats
    shifts: Floats


class CloudLook:
    """The clouds among a world's obstacles, with boxes around them and the bodies."""

    def __init__(self, world: World) -> None:
        self._world, self._chain = world, Chain.from_arm(world.robot)
        self.numbers = np.array([k for k, item in enumerate(world.obstacles) if isinstance(item.shape, Points)], int)
        boxes = np.reshape([bounding_box(world.obstacles[k].shape) for k in self.numbers], (-1, 2, 3))
        placements = np.reshape([world.obstacles[k].placement for k in self.numbers], (-1, 4, 4))
        self._middles = (placements[:, :3, :3] @ boxes.mean(axis=1)[:, :, None])[..., 0] + placements[:, :3, 3]
        self._sizes = 0.5 * np.linalg.norm(boxes[:, 1] - boxes[:, 0], axis=1)

    def near(self, q: Floats, reach: Floats) -> Iterator[NearBlocks]:
        """Yield per pair the blocks within ``reach`` (pairs,) m of a box around the body at q (n, dof)."""
        if not len(self.numbers):
            return
        rotation, position = joint_placements(self._chain, q)
        for b, body in enumerate(self._world.bodies):
            low, high = bounding_box(body.shape)
            turns = rotation[body.joint] @ body.placement[:3, :3]
            shifts = rotation[body.joint] @ body.placement[:3, 3] + position[body.joint]
            pairs = b * len(self._world.obstacles) + self.numbers
            apart = np.linalg.norm(turns @ (0.5 * (low + high)) + shifts - self._middles[:, None], axis=2)
            meets = apart <= (self._sizes + 0.5 * np.linalg.norm(high - low) + reach[pairs])[:, None]
            for k in np.flatnonzero(self._world.checked[b, self.numbers] & meets.any(axis=1)):
                item, rows = self._world.obstacles[self.numbers[k]], np.flatnonzero(meets[k])
                assert isinstance(item.shape, Points)
                turn, shift = item.placement[:3, :3], item.placement[:3, 3]
                turned, shifted = turn.T @ turns[rows], (shifts[rows] - shift) @ turn
                blocks = blocks_of(item.shape)
                which, block = np.nonzero(_meet(blocks, low, high, turned, shifted, float(reach[pairs[k]])))
                if len(which):
                    yield NearBlocks(int(pairs[k]), rows[which], block, turned[which], shifted[which])


def _meet(blocks: Blocks, low: Floats, high: Floats, turns: Floats, shifts: Floats, reach: float) -> Bools:
    """Return which blocks (n, m) may be within ``reach`` (m) of a box in the given placements (n,)."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    between = blocks.middles - (turns @ middle + shifts)[:, None]  # (n, m, 3)
    along = (np.abs(turns) @ half)[:, None] + blocks.halves + reach
    across = half + np.linalg.norm(blocks.halves, axis=1)[:, None] + reach
    return (np.abs(between) <= along).all(axis=2) & (np.abs(between @ turns) <= across).all(axis=2)
