"""How far from a contact the verdicts of two checkers still differ, and why."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.collision.checker import CollisionChecker, contact_of, is_free
from planner.collision.world import Contact
from planner.kinematics.forward import joint_placements

_BAND = 1e-5  # m: each library stops its iterations at a tolerance of its own, about 1e-6 m
_MARGIN_BAND = 1e-4  # m: FCL's distances between convex shapes are lowered to what a plane proves
_STEPS = tuple(10.0**k for k in np.arange(-9.0, -1.9, 0.5))  # m of motion before and behind a contact
_PRECISION = 1e-12  # m of motion


@dataclass(frozen=True)
class Disagreement:
    """A configuration on which the two differ: the pair that one of them finds touching, as both measure it.

    ``fcl_m`` and ``coal_m``: the distance of the pair (m), 0 or less where it touches (FCL gives no depth but -1); None
    where that checker does not check the pair. ``band_m``: how far coal's distance is from the ``margin``, where the
    verdict changes.
    """

    margin: float

    touching_by: str
    first: str
    second: str
    fcl_m: float | None
    coal_m: float | None
    band_m: float
    q: tuple[float, ...]

    @property
    def explained(self) -> bool:
        """Whether it is so near a contact that both libraries are right within their tolerances."""
        return self.band_m <= band(self.margin)


def band(margin: float) -> float:
    """How near a contact, or the margin (m) where there is one, the two libraries may differ (m)."""
    return _MARGIN_BAND if margin > 0 else _BAND


def disagreement(fcl: CollisionChecker, coal: CollisionChecker, q: Floats) -> Disagreement | None:
    """Whether two checkers of one robot and scene differ on a configuration (dof,), and why."""
    by_fcl, by_coal = contact_of(fcl, q), contact_of(coal, q)
    if (by_fcl is None) == (by_coal is None):
        return None
    contact = by_fcl or by_coal
    assert contact is not None
    fcl_m, coal_m = (_distance(checker, contact, q) for checker in (fcl, coal))
    margin = coal.world.margin
    apart = float("inf") if coal_m is None or fcl_m is None else abs(coal_m - margin)
    by = "fcl" if by_fcl else "coal"
    return Disagreement(margin, by, contact.first, contact.second, fcl_m, coal_m, apart, tuple(q.tolist()))


def _distance(checker: CollisionChecker, contact: Contact, q: Floats) -> float | None:
    """The smallest distance of the pairs of the names in ``contact``; a link may have several bodies."""
    world = checker.world
    pairs = np.array([p for p in range(len(world.pair_reach)) if world.contact(p) == contact], dtype=np.int64)
    if not len(pairs):
        return None
    rotation, position = joint_placements(checker.chain, q[None])
    return float(checker.distances(rotation[:, 0], position[:, 0], pairs).min())


def crossing(fcl: CollisionChecker, coal: CollisionChecker, free: Floats, touching: Floats) -> list[Disagreement]:
    """All disagreements found around a contact between a free and a touching configuration (dof,).

    Bisection finds the place between the two where FCL's verdict changes. Then both checkers are asked before and
    behind it, at growing distances of motion from a nanometre to a centimetre, until they agree on both sides.
    """
    delta = fcl.robot.difference(free, touching)
    motion = float(fcl.world.reach.motion(delta[None]).max())
    low, high = 0.0, 1.0
    while (high - low) * motion > _PRECISION:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        low, high = (middle, high) if is_free(fcl, free + middle * delta) else (low, middle)
    found: list[Disagreement] = []
    for step in _STEPS:
        sides = (max(0.0, low - step / motion), min(1.0, high + step / motion))
        differ = [one for at in sides if (one := disagreement(fcl, coal, free + at * delta)) is not None]
        if not differ:
            break
        found += differ
    return found
