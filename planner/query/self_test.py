"""Self-test of a robot description: home, random configurations, tool positions, and links that touch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from planner.base.arrays import Bools, Floats, frozen
from planner.base.errors import StateError
from planner.collision.checker import APART, CollisionChecker
from planner.kinematics.forward import joint_placements, tool_positions
from planner.problem.targets import Position
from planner.query.resolve import resolve
from planner.robot.robot import Robot

_SAMPLES, _TARGETS = 200, 8
_STEPS = 17  # configurations on the way from home
_OFTEN = 0.5  # share of random configurations from which on a pair that touches is named


def try_robot(checker: CollisionChecker) -> Iterator[str]:
    """Sentences on how usable the robot of ``checker`` is in its scene, and which pairs of links stand in the way."""
    robot, random = checker.robot, _random(checker.robot)
    at_home, touching = _touching(checker, robot.home[None])[0], _touching(checker, random)
    reached = sum(_is_reached(checker, xyz) for xyz in tool_positions(robot, random[:_TARGETS]).tolist())
    yield (
        f"Tried without obstacles: home is {'in collision' if at_home.any() else 'free'}, {reached} of {_TARGETS} tool "
        f"positions are reached, {100 * (~touching.any(axis=1)).mean():.0f} % of random configurations are free."
    )
    shares, home = touching.mean(axis=0), set[tuple[str, str]]()
    often: dict[tuple[str, str], float] = {}
    for pair in np.flatnonzero(at_home | (shares >= _OFTEN)).tolist():
        contact = checker.world.contact(pair)
        names = min(contact.first, contact.second), max(contact.first, contact.second)
        home |= {names} if at_home[pair] else set()
        often[names] = max(float(shares[pair]), often.get(names, 0.0))
    for (first, second), share in sorted(often.items()):
        where = ["at home"] * ((first, second) in home) + [f"in {100 * share:.0f} % of random configurations"] * (
            share >= _OFTEN
        )
        yield (
            f"'{first}' and '{second}' touch {' and '.join(where)}: if the real ones do not, give the URDF simpler "
            f'collision geometry there, or add ["{first}", "{second}"] to disabled_pairs of the file.'
        )


def with_free_home(checker: CollisionChecker) -> CollisionChecker:
    """The same checker of its robot with a home near the given one in which nothing touches, if one is found.

    It lies on the way to the middle of the limits, else on that to the nearest of random free configurations.
    """
    robot, random = checker.robot, _random(checker.robot)
    if not _touching(checker, robot.home[None]).any():
        return checker
    for ends in (0.5 * (robot.lower + robot.upper)[None], random[~_touching(checker, random).any(axis=1)]):
        found = [near for end in ends if (near := _on_the_way(checker, end)) is not None]
        if found:
            home = frozen(min(found, key=lambda near: float(np.abs(near - robot.home).sum())))
            return type(checker)(replace(checker.world, robot=replace(robot, home=home)), checker)
    return checker


def _random(robot: Robot) -> Floats:
    return np.random.default_rng(0).uniform(robot.lower, robot.upper, size=(_SAMPLES, robot.dof))


def _on_the_way(checker: CollisionChecker, end: Floats) -> Floats | None:
    """Of some configurations (dof,) from home to ``end`` the first free one with a free one after it."""
    robot = checker.robot
    way = robot.home + np.linspace(0.0, 1.0, _STEPS)[:, None] * (end - robot.home)
    way = np.clip(np.round(way, 3), robot.lower, robot.upper)  # people read it
    free: Bools = ~np.any(_touching(checker, way), axis=1)
    roomy = np.flatnonzero(free[:-1] & free[1:])
    return way[roomy[0]] if len(roomy) else None


def _touching(checker: CollisionChecker, q: Floats) -> Bools:
    """(n, pairs) which pairs are not proven apart in which configurations."""
    rotation, position = joint_placements(checker.chain, q)
    touching = checker.bound.coarse(rotation, position) <= 0
    rows, pairs = np.nonzero(touching)
    touching[rows, pairs] = checker.bound.close(rotation, position, rows, pairs, APART) <= 0
    return touching


def _is_reached(checker: CollisionChecker, xyz: tuple[float, float, float]) -> bool:
    try:
        resolve(Position(tuple(xyz)), checker, {}, "goal")
    except StateError:
        return False
    return True
