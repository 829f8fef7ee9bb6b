"""Why a tool path cannot be followed beyond a place: reach, limits, contacts, the floor, or a jump."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.collision.checker import CollisionChecker, contact_of
from planner.kinematics.inverse import POSITION_TOLERANCE
from planner.problem.outcome import CannotFollow
from planner.robot.robot import Robot
from planner.tool_paths.ladder import solutions_at
from planner.tool_paths.ladder_roadmap import Reached
from planner.tool_paths.tube import Tube

_STARTS = 300
_CONES = (0.0, 0.05, 0.1, 0.2, 0.4, 0.8)  # rad
_LOOKED_AT = 40  # solutions whose contacts are named


def why_not(
    checker: CollisionChecker,
    found: Reached,
    reached: Floats | None = None,
    floor: float | None = None,
) -> CannotFollow:
    """The reason why the path is not followed beyond what is ``found``, by its next station.

    ``reached`` (k, dof) is where it ends, where the ladder does not say so; ``floor`` is one that lets it go on, where
    the one asked for is all that is in the way.
    """
    ladder, ends = found.ladder, found.ends if reached is None else reached
    robot, path, stations = ladder.robot, ladder.tube.path, ladder.stations
    beyond = stations[stations > found.share * stations[-1] + 1e-9] if len(ends) else stations[:1]
    there = float(beyond[0]) if len(beyond) else float(stations[-1])
    line = min(int(np.searchsorted(path.along, there - 1e-9)), len(path.along) - 1)
    begun: dict[str, Any] = {"point": int(path.given[line]), "followed": found.share}
    if floor is not None:
        return CannotFollow(cause="below_floor", reachable=floor, **begun)
    q, miss = _solutions(robot, ladder.tube, there)
    if not len(q):
        begun |= {"cone": _cone(robot, ladder.tube, there)}
        return _no_solution(robot, ladder.tube, there, miss, begun)
    keeps = checker.world.keeps
    kept = keeps.holds(q)
    if not kept.any():
        spare = max(keeps.spare(q), key=np.min)
        return CannotFollow(
            cause="strays", between=(keeps.texts[spare.argmin()],), distance=float(-spare.min()), **begun
        )
    q = q[kept]
    contacts = [contact_of(checker, one) for one in q[:_LOOKED_AT]]
    if all(contacts):
        named = Counter((found.first, found.second) for found in contacts if found)
        return CannotFollow(cause="touching", between=named.most_common(1)[0][0], **begun)
    free = q[[k for k, found in enumerate(contacts) if found is None]]
    away = 0.0
    if len(ends):
        away = float(np.abs(robot.difference(ends[:, None], free[None])).max(axis=2).min())
    return CannotFollow(cause="jump", distance=away, **begun)


def _solutions(robot: Robot, tube: Tube, along: float, starts: int = _STARTS) -> tuple[Floats, Floats]:
    """Solutions (k, dof) at a place of the path, and by how much (m, rad) the nearest try misses it."""
    q, off = solutions_at(robot, tube, along, starts, np.random.default_rng(0))
    return q[np.isfinite(q[:, 0])], off[(off[:, 0] + 0.1 * off[:, 1]).argmin()]


def _no_solution(robot: Robot, tube: Tube, there: float, miss: Floats, begun: dict[str, Any]) -> CannotFollow:
    """By how much it is out of reach, or which limits keep the arm from it."""
    wide = np.where(robot.prismatic, 10.0, 4.0 * np.pi)
    unlimited = replace(robot, lower=frozen(robot.lower - wide), upper=frozen(robot.upper + wide))
    q, _ = _solutions(unlimited, tube, there)
    if len(q):
        turned = np.where(robot.prismatic, q, np.mod(q - robot.lower, 2 * np.pi) + robot.lower)
        over = np.where(robot.continuous, 0.0, np.maximum(robot.lower - turned, turned - robot.upper))
        least = over[np.maximum(over, 0.0).sum(axis=1).argmin()]
        joints = tuple(name for name, more in zip(robot.joints, least, strict=True) if more > 0)
        return CannotFollow(cause="beyond_limit", between=joints or robot.joints, **begun)
    if miss[0] > POSITION_TOLERANCE:
        return CannotFollow(cause="out_of_reach", distance=float(miss[0]), **begun)
    return CannotFollow(cause="turned", distance=float(miss[1]), **begun)


def _cone(robot: Robot, tube: Tube, there: float) -> float | None:
    """The narrowest cone (rad) with which solutions are found at a place; 0 where a free turn will do."""
    path = tube.path
    n = len(path.positions)
    for cone in _CONES:
        if (cone > path.cones.max()) if cone else not path.free.any():
            wider = replace(path, free=np.ones(n, bool), cones=np.full(n, cone))
            if len(_solutions(robot, replace(tube, path=wider), there)[0]):
                return cone
    return None
