"""Whether FCL and coal agree on random configurations of a world, and how far from a contact they still differ."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker, contact_of, is_free
from planner.collision.world import Contact
from planner.kinematics.forward import joint_placements
from planner.problem.request import PlanRequest
from planner.robot.robot import Robot
from planner.robot.scene import Scene

_CROSSINGS = 40  # contacts of each world whose surroundings are checked
_LISTED = 20  # disagreements of a row that are kept one by one

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


def agreement(robot: Robot, scene: Scene, request: PlanRequest, states: int) -> dict[str, Any]:
    """The columns of a row about ``states`` random configurations within limits, which both libraries judge."""
    fcl, coal = (make_checker(robot, scene, name, request.what.margin) for name in ("fcl", "coal"))
    rng = np.random.default_rng([request.quality.seed, *robot.name.encode(), *scene.name.encode()])
    q = rng.uniform(robot.lower, robot.upper, (states, robot.dof))
    by_fcl, by_coal = (np.array([is_free(checker, row) for row in q]) for checker in (fcl, coal))
    differ = [one for row in q[by_fcl != by_coal] if (one := disagreement(fcl, coal, row)) is not None]
    both, neither = q[by_fcl & by_coal], q[~by_fcl & ~by_coal]
    count = min(_CROSSINGS, len(both), len(neither))
    around = [one for a, b in zip(both[:count], neither[:count], strict=True) for one in crossing(fcl, coal, a, b)]
    worst = sorted((one for one in around if not one.explained), key=lambda one: -one.band_m)
    listed = [asdict(one) for one in [*differ, *worst][:_LISTED]]
    return {
        "states": states,
        "free": int(by_fcl.sum()),
        "disagreed": int((by_fcl != by_coal).sum()),
        "unexplained": sum(not one.explained for one in differ),
        "batch_differs": sum(batch_differences(checker, both, neither) for checker in (fcl, coal)),
        "crossings": count,
        "band_m": max((one.band_m for one in around), default=0.0),
        "outside": len(worst),
        "listed": json.dumps(listed) if listed else "",
    }


def batch_differences(checker: CollisionChecker, free: Floats, touching: Floats) -> int:
    """Configurations on which a checker changes its verdict when it is asked about them together with others."""
    wrong = 0 if not len(free) or checker.bound.looks_free(free) else 1
    beside = free[:1] if len(free) else touching[:0]
    for q in touching:
        batch = np.vstack([beside, q, beside])
        found = checker.first_contact(batch)
        wrong += found is None or found[0] != len(beside) or checker.bound.looks_free(batch)
    return wrong


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
