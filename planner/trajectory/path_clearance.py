"""The smallest clearance along a joint path, to a tolerance, and which pair it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, so_far
from planner.base.resolutions import CLEARANCE_FIRST
from planner.collision.checker import CollisionChecker
from planner.collision.clearance import Clearance
from planner.collision.world import Contact

TOLERANCE, SHARE = 1e-3, 0.1  # m, and of the clearance itself: what is reported is too large by less than either
CLOSE = 5e-3  # m: models of one robot differ by a millimetre, and calibrations by more
TOO_CLOSE = "close"  # the row of the summary that is there only where something comes closer than CLOSE
TOO_CLOSE_TEXT = (
    f"less than {1000 * CLOSE:g} mm, by which the robot's true shape or place may differ: --margin 0.005 keeps a "
    "distance for certain, at start and goal too; --room 0.01 lets refined paths keep more where there is more"
)
SHOWN = 1e-4  # m: the smallest clearance that is printed; proofs need about twice that


@dataclass(frozen=True, eq=False)
class Place:
    """A value at a place of a path: on ``segment`` (from 0), at ``share`` of its length, configuration ``q`` (dof,)."""

    segment: int
    share: float
    q: Floats
    value: float


def smallest_clearance(checker: CollisionChecker, path: Floats) -> Place | None:
    """The smallest clearance (m) along a path (k, dof), to 1 mm and to a tenth; None where no pair is checked.

    A distance changes by no more than its two bodies move, so between two samples at ``left`` and ``right``, ``motion``
    apart, it is at least (left + right - motion) / 2. Pieces that may hide one that is smaller by more than that are
    halved, all at a time, until there are none (Piyavskii 1972). The backend's own error comes on top.
    """
    search = _Search(checker, path)
    while search.halve():
        pass
    return search.best if np.isfinite(search.best.value) else None


def clearance_text(clearance: float) -> str:
    """A clearance (m) for people: one that would be printed as 0.0 mm says what it means."""
    if clearance >= SHOWN:
        return f"{1000 * clearance:.1f} mm"
    return f"less than {1000 * SHOWN:g} mm, which no proof can tell from contact"


def slack(clearance: float) -> float:
    """By how much (m) a reported ``clearance`` may be too large."""
    return min(TOLERANCE, SHARE * clearance)


def nearest_pair(checker: CollisionChecker, q: Floats) -> Contact | None:
    """The checked pair that is nearest at ``q`` (dof,), of those that some joint can move; None where there is none."""
    world = checker.world
    checked = np.concatenate([world.checked.ravel(), np.ones(len(world.self_pairs), dtype=bool)])
    pairs = np.flatnonzero(checked & world.moving)
    if not len(pairs):
        return None
    return world.contact(int(pairs[checker.gaps(q, pairs).argmin()]))


class _Search:
    """Pieces of the path that are halved where they may hide a smaller clearance.

    They are ``CLEARANCE_FIRST`` long at first, whatever the waypoints: a trajectory has thousands of them.
    """

    def __init__(self, checker: CollisionChecker, path: Floats) -> None:
        self.path, self.clearance = path, Clearance(checker)
        # two bodies may come nearer by what both of them move
        motion = (checker.chain.sizes(np.diff(path, axis=0)) @ checker.world.pair_reach.T).max(axis=1, initial=0.0)
        self.passed = so_far(motion)  # (k,) motion from the start to each waypoint
        self.best = Place(0, 0.0, path[0], np.inf)
        length = float(self.passed[-1])
        places = np.linspace(0.0, length, max(1, int(np.ceil(length / CLEARANCE_FIRST))) + 1)
        values = self._look(places)
        # (4, n): from where to where they go, in metres of motion from the start, and the clearance or less there
        self._pieces = np.stack([places[:-1], places[1:], values[:-1], values[1:]])

    def halve(self) -> bool:
        """Look in the middle of the pieces that could hold a smaller clearance; whether there were any."""
        low, high, left, right = self._pieces
        bound = np.maximum(0.0, 0.5 * (left + right - (high - low)))
        hiding = np.isfinite(bound) & (bound < self.best.value - slack(self.best.value))
        if not hiding.any():
            return False
        low, high, left, right = self._pieces[:, hiding]
        middle = 0.5 * (low + high)
        value = self._look(middle)
        self._pieces = np.concatenate([[low, middle, left, value], [middle, high, value, right]], axis=1)
        return True

    def _look(self, places: Floats) -> Floats:
        """The clearances (n,) at ``places`` (n,) of which one is a new best one, if any is; lower bounds of others."""
        segment = np.clip(np.searchsorted(self.passed, places, side="right") - 1, 0, max(0, len(self.path) - 2))
        ahead = np.minimum(segment + 1, len(self.path) - 1)
        a, b = self.path[segment], self.path[ahead]
        share = (places - self.passed[segment]) / np.maximum(self.passed[ahead] - self.passed[segment], 1e-300)
        q = a + share[:, None] * (b - a)
        values = self.clearance.smallest(q, self.best.value)
        row = int(values.argmin())
        if values[row] < self.best.value:
            self.best = Place(int(segment[row]), float(share[row]), q[row], float(values[row]))
        return values
