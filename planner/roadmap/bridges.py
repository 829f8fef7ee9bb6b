"""Bridges between two parts of a roadmap: the shortest straight motions that are proven, else a path by RRTConnect."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from planner.base.arrays import Floats
from planner.base.progress import QUIET, Progress
from planner.collision.edge_prover import EdgeProver
from planner.roadmap.connections import nearest_of
from planner.roadmap.first_path import FirstPathSearch
from planner.roadmap.grow import join_settings
from planner.roadmap.growth_settings import GrowthSettings
from planner.roadmap.shortcuts import in_pieces
from planner.roadmap.straight_motions import Motions
from planner.robot.robot import Robot

_PER_NODE = 4  # nodes of the other part, the nearest ones, that each node is paired with
_FIRST, _MOST = 32, 1024  # pairs proven together, twice as many each time, and pairs proven at most


def bridges(
    prover: EdgeProver,
    part: Floats,
    other: Floats,
    seed: int = 0,
    settings: GrowthSettings | None = None,
    progress: Progress = QUIET,
) -> list[Floats]:
    """Paths (k, dof) of proven motions between nodes ``part`` (n, dof) and ``other`` (m, dof); empty if none is found.

    Pairs of near nodes are proven, the shortest first, until some hold: these come back, and nothing else is tried.
    Where none of ``_MOST`` holds, RRTConnect searches near the shortest pair, then everywhere from all nodes at once,
    by the counts of ``settings``. In pieces no longer than ``settings.range``. The same seed gives the same paths.
    """
    robot, settings = prover.robot, settings or GrowthSettings()
    pairs = _near_pairs(robot, part, other)
    for ends in _batches(pairs):
        free = prover.free(ends[:, 0], robot.difference(ends[:, 0], ends[:, 1]))
        if free.any() or progress.stopped:
            return [in_pieces(prover, pair, settings.range) for pair in ends[free]]
    rng = np.random.default_rng(seed)
    search = FirstPathSearch(Motions(prover), join_settings(settings, robot), rng, progress)
    path = search.join_near(part, other, pairs[0]) if len(pairs) else None
    if path is None:
        path = search.join(part, other)
    return [] if path is None else [path]


def _near_pairs(robot: Robot, part: Floats, other: Floats) -> Floats:
    """(k, 2, dof) ends of straight motions from near nodes of one part to the other, the shortest first."""
    if not (len(part) and len(other)):
        return np.zeros((0, 2, robot.dof))
    swapped = len(part) < len(other)
    many, few = (other, part) if swapped else (part, other)
    length, row = nearest_of(robot, many, few, min(_PER_NODE, len(many)))
    order = np.argsort(length, axis=None, kind="stable")[:_MOST]
    ends = few[order // length.shape[1]], many[row.ravel()[order]]
    return np.stack(ends if swapped else ends[::-1], axis=1)


def _batches(pairs: Floats) -> Iterator[Floats]:
    """The pairs in order, ``_FIRST`` of them and then twice as many each time."""
    begin, size = 0, _FIRST
    while begin < len(pairs):
        yield pairs[begin : begin + size]
        begin, size = begin + size, 2 * size
