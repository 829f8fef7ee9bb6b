"""The smallest clearance along a joint path, to a tolerance, and which pair it is."""

from __future__ import annotations

import heapq
import itertools
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
    apart, it is at least (left + right - motion) / 2. The piece that may hide the smallest is halved until none can
    hide one that is smaller by more than that (Piyavskii 1972). The backend's own error comes on top.
    """
    search = _Search(checker, path)
    while search.pieces and search.pieces[0].bound < search.best.value - slack(search.best.value):
        search.halve()
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


@dataclass(frozen=True, order=True)
class _Piece:
    """The path between two samples, ``low`` and ``high`` metres of motion from its start; sorted by its lower bound."""

    bound: float
    low: float
    high: float
    left: float
    right: float


class _Search:
    """Pieces of the path, the one that may hide the smallest clearance first.

    They are ``CLEARANCE_FIRST`` long at first, whatever the waypoints: a trajectory has thousands of them.
    """

    def __init__(self, checker: CollisionChecker, path: Floats) -> None:
        self.path, self.clearance = path, Clearance(checker)
        # two bodies may come nearer by what both of them move
        motion = (np.abs(np.diff(path, axis=0)) @ checker.world.pair_reach.T).max(axis=1, initial=0.0)
        self.passed = so_far(motion)  # (k,) motion from the start to each waypoint
        self.best = Place(0, 0.0, path[0], np.inf)
        self.pieces: list[_Piece] = []
        length = float(self.passed[-1])
        places = np.linspace(0.0, length, max(1, int(np.ceil(length / CLEARANCE_FIRST))) + 1).tolist()
        bounds = self.clearance.at_least(np.array([self._at(place)[2] for place in places]))
        values = dict(sorted((k, self._look(places[k])) for k in np.argsort(bounds, kind="stable").tolist()))
        looks = zip(places, values.values(), strict=True)
        for (low, left), (high, right) in itertools.pairwise(looks):
            self._push(low, high, left, right)

    def halve(self) -> None:
        """Look in the middle of the piece that could hold the smallest clearance."""
        piece = heapq.heappop(self.pieces)
        middle = 0.5 * (piece.low + piece.high)
        value = self._look(middle)
        self._push(piece.low, middle, piece.left, value)
        self._push(middle, piece.high, value, piece.right)

    def _look(self, place: float) -> float:
        """The clearance ``place`` metres of motion from the start; where it is no new best one a lower bound on it."""
        segment, share, q = self._at(place)
        value = float(self.clearance(q, self.best.value)[0])
        if value < self.best.value:
            self.best = Place(segment, share, q, value)
        return value

    def _at(self, place: float) -> tuple[int, float, Floats]:
        """The segment, the share of it and the configuration ``place`` metres of motion from the start."""
        segment = int(np.searchsorted(self.passed, place, side="right")) - 1
        segment = max(0, min(segment, len(self.path) - 2))
        a, b = self.path[segment], self.path[min(segment + 1, len(self.path) - 1)]
        share = float((place - self.passed[segment]) / max(np.ptp(self.passed[segment : segment + 2]), 1e-300))
        return segment, share, a + share * (b - a)

    def _push(self, low: float, high: float, left: float, right: float) -> None:
        bound = 0.5 * (left + right - (high - low))
        if np.isfinite(bound):
            heapq.heappush(self.pieces, _Piece(max(0.0, float(bound)), low, high, left, right))
