"""A robot tried before a user does: home, random configurations, targets, and which pairs of links stand in the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Bools, Floats
from planner.base.errors import StateError
from planner.collision.checker import APART, CollisionChecker
from planner.kinematics.forward import joint_placements, tool_positions
from planner.problem.targets import Position
from planner.setup.resolve import resolve

_SAMPLES, _TARGETS = 200, 8
_STEPS = 17  # configurations on the way from home
OFTEN = 0.5  # share of random configurations from which on a pair that touches is named


@dataclass(frozen=True)
class Trial:
    """What came of it: pairs of links that touch at home, and in how many random configurations pairs touch often.

    ``free``: the share of random configurations in which nothing touches; ``reached``: of ``targets`` the tool's
    positions, taken from random configurations, those that some free configuration reaches.
    """

    home: tuple[tuple[str, str], ...]
    often: Mapping[tuple[str, str], float]
    free: float
    reached: int
    targets: int

    @property
    def in_the_way(self) -> list[tuple[str, str]]:
        """Pairs that make the robot hard or impossible to use, sorted."""
        return sorted({*self.home, *self.often})


def try_robot(checker: CollisionChecker, seed: int = 0) -> Trial:
    """Try the robot of ``checker`` in its scene; the same for a seed."""
    robot, rng = checker.robot, np.random.default_rng(seed)
    q = np.vstack([robot.home, rng.uniform(robot.lower, robot.upper, size=(_SAMPLES, robot.dof))])
    touching = _touching(checker, q)
    names = [_names(checker, pair) for pair in range(touching.shape[1])]
    home = sorted({names[pair] for pair in np.flatnonzero(touching[0])})
    shares: dict[tuple[str, str], float] = {}
    for name, share in zip(names, touching[1:].mean(axis=0).tolist(), strict=True):
        shares[name] = max(share, shares.get(name, 0.0))
    often = {name: share for name, share in sorted(shares.items()) if share >= OFTEN}
    reached = sum(_is_reached(checker, xyz) for xyz in tool_positions(robot, q[1 : _TARGETS + 1]).tolist())
    return Trial(tuple(home), often, float((~touching[1:].any(axis=1)).mean()), reached, _TARGETS)


def free_home(checker: CollisionChecker, seed: int = 0) -> Floats | None:
    """A configuration (dof,) in which nothing touches, near home: home itself where that is free; None for none found.

    On the way from home to the middle of the limits, else to random free configurations, whichever is nearest.
    """
    robot, rng = checker.robot, np.random.default_rng(seed)
    if not _touching(checker, robot.home[None]).any():
        return robot.home
    middle = _on_the_way(checker, 0.5 * (robot.lower + robot.upper))
    if middle is not None:
        return middle
    q = rng.uniform(robot.lower, robot.upper, size=(_SAMPLES, robot.dof))
    free = q[~_touching(checker, q).any(axis=1)]
    found = [near for end in free if (near := _on_the_way(checker, end)) is not None]
    return min(found, key=lambda near: float(np.abs(near - robot.home).sum()), default=None)


def _on_the_way(checker: CollisionChecker, end: Floats) -> Floats | None:
    """Of some configurations (dof,) from home to ``end`` the first free one with a free one after it."""
    robot = checker.robot
    way = robot.home + np.linspace(0.0, 1.0, _STEPS)[:, None] * (end - robot.home)
    way = np.clip(np.round(way, 3), robot.lower, robot.upper)  # people read it
    free: Bools = ~np.any(_touching(checker, way), axis=1)
    roomy = np.flatnonzero(free[:-1] & free[1:])
    return way[roomy[0]] if len(roomy) else None


def _touching(checker: CollisionChecker, q: np.ndarray) -> Bools:
    """(n, pairs) which pairs are not proven apart in which configurations."""
    rotation, position = joint_placements(checker.chain, q)
    touching = checker.bound.coarse(rotation, position) <= 0
    rows, pairs = np.nonzero(touching)
    touching[rows, pairs] = checker.bound.close(rotation, position, rows, pairs, APART) <= 0
    return touching


def _names(checker: CollisionChecker, pair: int) -> tuple[str, str]:
    contact = checker.world.contact(pair)
    return min(contact.first, contact.second), max(contact.first, contact.second)


def _is_reached(checker: CollisionChecker, xyz: list[float]) -> bool:
    x, y, z = xyz
    try:
        resolve(Position((x, y, z)), checker, {}, "goal")
    except StateError:
        return False
    return True
