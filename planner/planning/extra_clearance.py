"""The clearance beyond the margin that refined paths and motions keep: as asked, or half of it, a quarter, ...

A path that has been made short or well conditioned grazes what stands in its way. So the edges of a plan's network, the
motions that refinement tries and the shortcuts in time have to keep a few millimetres more, wherever start, goal and
the narrowest passage between them leave so much.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from planner.base.arrays import Floats
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker, keeping
from planner.collision.edge_prover import EdgeProver
from planner.roadmap.roadmap import Roadmap, segments

_HALVES = 6  # 5 mm: down to 0.16 mm, where proofs end


def with_clearance(
    roadmap: Roadmap,
    checker: CollisionChecker,
    wanted: float,
    joins: Callable[[Roadmap, float], bool],
    progress: Progress = QUIET,
) -> tuple[Roadmap, float]:
    """The largest of ``wanted``, its half, ... (m) at which edges of so much clearance still join the ends; or 0.

    ``joins`` tells whether they do. The roadmap comes back with the certificates of edges that were proven on the way.
    """
    if wanted <= 0 or not joins(roadmap, 0.0):
        return roadmap, 0.0
    for clearance in halves(wanted):
        roadmap = _judged(roadmap, checker, clearance, progress)
        if progress.stopped:
            break
        if joins(roadmap, clearance):
            return roadmap, clearance
    return roadmap, 0.0


def _judged(roadmap: Roadmap, checker: CollisionChecker, clearance: float, progress: Progress) -> Roadmap:
    """With a proof of each edge whose certificate leaves open whether it has so much ``clearance`` (m)."""
    rows = np.flatnonzero(roadmap.clearance < clearance)
    wider = keeping(checker, clearance)
    proofs = EdgeProver(wider, progress).prove(*segments(roadmap, checker.robot, rows), contacts=False)
    known, free = roadmap.clearance.copy(), proofs.free
    known[rows[free]] = clearance + np.maximum(proofs.clearance[free], 0.0)
    return replace(roadmap, clearance=known)


def clearance_of_path(path: Floats, checker: CollisionChecker, wanted: float) -> float:
    """The largest of ``wanted``, its half, ... (m) that all motions of a ``path`` (k, dof) are proven to keep; or 0."""
    if wanted <= 0 or len(path) < 2:
        return 0.0
    start, delta = path[:-1], np.diff(path, axis=0)
    for clearance in halves(wanted):
        if EdgeProver(keeping(checker, clearance)).free(start, delta).all():
            return clearance
    return 0.0


def halves(wanted: float) -> list[float]:
    """``wanted``, half of it, and so on."""
    return [wanted * 0.5**k for k in range(_HALVES)]
