"""The samples of clouds that come near a body, for a second look at these alone.

KD-trees of SciPy find them, so a fault of the tree that proofs use cannot hide a sample from both.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.collision.bounding_volumes import sphere_cover
from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.clouds import Points
from planner.robot.shapes import Box, bounding_box

_BALLS = 32  # around a body's box: more are closer to it, and cost a search each
_ROUNDING = 1e-9  # m


class NearSamples(NamedTuple):
    """Samples that a pair's body comes near in configurations ``rows`` (m,).

    It stands there at ``turns`` (m, 3, 3) and ``shifts`` (m, 3) in the frame of the cloud. ``samples`` are (k, 3), m.
    """

    pair: int
    rows: Ints
    samples: Floats
    turns: Floats
    shifts: Floats


class CloudLook:
    """The clouds among a world's obstacles, and boxes around the bodies."""

    def __init__(self, world: World) -> None:
        self._world, self._chain = world, Chain.from_arm(world.robot)
        self.numbers = np.array([k for k, item in enumerate(world.obstacles) if isinstance(item.shape, Points)], int)
        boxes = np.reshape([bounding_box(world.obstacles[k].shape) for k in self.numbers], (-1, 2, 3))
        placements = np.reshape([world.obstacles[k].placement for k in self.numbers], (-1, 4, 4))
        self._middles = (placements[:, :3, :3] @ boxes.mean(axis=1)[:, :, None])[..., 0] + placements[:, :3, 3]
        self._sizes = 0.5 * np.linalg.norm(boxes[:, 1] - boxes[:, 0], axis=1)

    def near(self, q: Floats, reach: Floats) -> Iterator[NearSamples]:
        """Yield per pair the samples within ``reach`` (pairs,) m of a box around the body at q (n, dof).

        Pairs without such a sample are left out.
        """
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
                own = turn.T @ turns[rows], (shifts[rows] - shift) @ turn
                met, samples = samples_in_boxes(item.shape, low, high, *own, float(reach[pairs[k]]))
                if len(met):
                    points = item.shape.vertices[samples]
                    yield NearSamples(int(pairs[k]), rows[met], points, own[0][met], own[1][met])


def samples_in_boxes(
    cloud: Points, low: Floats, high: Floats, turns: Floats, shifts: Floats, reach: float
) -> tuple[Ints, Ints]:
    """Return which placements (n,) of a box have samples within ``reach`` (m), and all these samples.

    The box from ``low`` to ``high`` (3,) is placed at ``turns`` (n, 3, 3), ``shifts`` (n, 3) in the cloud's frame.
    """
    middle, half, reach = 0.5 * (low + high), 0.5 * (high - low), reach + _ROUNDING
    most = float(np.linalg.norm(half)) + reach
    rows = np.flatnonzero(np.isfinite(cloud.tree.query(turns @ middle + shifts, distance_upper_bound=most)[0]))
    cover = sphere_cover(Box(tuple(np.maximum(high - low, _ROUNDING).tolist())), _BALLS, reach)
    balls = turns[rows] @ (cover.centres + middle).T + shifts[rows, :, None]  # (rows, 3, balls)
    found = cloud.tree.query_ball_point(balls.swapaxes(1, 2).reshape(-1, 3), float(cover.radii[0]) + reach)
    row = np.repeat(np.repeat(rows, len(cover.radii)), [len(each) for each in found])
    sample = np.fromiter(itertools.chain.from_iterable(found), np.int64, len(row))
    local = ((cloud.vertices[sample] - shifts[row])[:, None] @ turns[row])[:, 0] - middle
    inside = (np.abs(local) <= half + reach).all(axis=1)
    return np.unique(row[inside]), np.unique(sample[inside])
