"""Chunks that keep a known distance from everything, with their stops, in the situations of a task.

An obstacle moves along a direction until coal finds the distance of a chunk and of all stops that limits allow; so what
a gate refuses there is refused without need.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.gate.chunks import KINDS, Chunk, Rng, sine_chunk
from benchmarks.gate.judge import motion_of, possible_stops, reach_of, states_on
from planner.base.arrays import Floats
from planner.base.errors import SceneError
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker, with_extra_margin
from planner.kinematics.forward import joint_placements, tool_pose
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle, Sphere
from planner.session.gate import Gate
from planner.session.verdict import Verdict

CLASSES = (1, 2, 5, 10, 20)  # mm beyond the margin
MARGIN = 5e-3  # m
SITUATIONS = ("empty", "table", "carrying", "grasp", "release")
_HAND, _FINGERS = "panda_hand", ("panda_leftfinger", "panda_rightfinger")
_READY = np.array([0.0, 0.35, 0.0, -2.0, 0.0, 2.35, 0.785])  # the hand points down, 0.5 m before the base
_PART = (0.04, 0.04, 0.04)  # m, between the fingers
_EVERY = 1e-3  # m between two states that coal looks at
_BATCH, _CLOSEST = 512, 8  # pairs whose bounds are improved, and of which coal measures the distance
_MOST_STEPS, _ACCURACY = 60, 2e-5  # m


@dataclass(frozen=True, eq=False)
class Stage:
    """A gate in a situation, the obstacle that sets the distance, and the direction (3,) that it moves away in."""

    gate: Gate
    near: str
    away: Floats


def stage(robot: Robot, situation: str, q: Floats, rng: Rng) -> Stage:
    """The gate of a situation around the configuration ``q``, its obstacle far away."""
    tool = tool_pose(robot, q).homogeneous
    table = Obstacle("table", Box((0.5, 1.2, 0.05)), pose([0.55, 0.0, tool[2, 3] - 0.3]))
    gate = Gate(robot, Scene(situation, (table,)), margin=MARGIN)
    if situation == "empty":
        shape = (Box(tuple(rng.uniform(0.05, 0.3, 3))), Sphere(rng.uniform(0.03, 0.15)))[int(rng.integers(2))]
        away = rng.normal(size=3)
        away /= np.linalg.norm(away)
        turned = pose((tool[:3, 3] + 0.8 * away).tolist(), rpy=rng.uniform(-3.0, 3.0, 3).tolist())
        gate.world.add(Obstacle("near", shape, turned))
        return Stage(gate, "near", away)
    part = Obstacle("part", Box(_PART), tool @ pose([0.0, 0.0, 0.018]))
    if situation in ("carrying", "release"):
        gate.world.attach(part, _HAND, q, _FINGERS)
    if situation == "release":  # it stands on the table already
        gate.allow("part", "table", box=[*(tool[:3, 3] - 0.5), *(tool[:3, 3] + 0.5)])
    if situation == "grasp":
        gate.world.add(part)
        for finger in _FINGERS:
            gate.allow(finger, "part", seconds=60.0)
    return Stage(gate, "table", np.array([0.0, 0.0, -1.0]))


def slow_chunk(situation: str, kind: str, steps: int, rng: Rng) -> Chunk:
    """A smooth motion of ``steps`` targets, 1/30 s apart, as slow as a task is in the situation."""
    size = {"grasp": 0.004, "release": 0.02}.get(situation, 0.08)
    times = np.arange(steps + 1) / 30.0
    start = _READY + rng.uniform(-0.15, 0.15, len(_READY))
    speed = rng.uniform(1.0, 3.0, (2, len(_READY)))
    height, phase = rng.normal(0.0, size, (2, len(_READY))), rng.uniform(0.0, 2.0 * np.pi, (2, len(_READY)))
    return sine_chunk(kind, times, start, speed, height, phase)


def judged_at(robot: Robot, situation: str, clearance: float, steps: int, rng: Rng) -> Verdict | None:
    """The verdict on a chunk that keeps ``clearance`` (m) beyond the margin; None for an unsuitable chunk."""
    chunk = slow_chunk(situation, KINDS[int(rng.integers(3))], steps, rng)
    try:
        there = stage(robot, situation, chunk.knots[0, 0], rng)
    except SceneError:  # an obstacle stands in the base
        return None
    columns, named = chunk.arguments()
    check: Callable[[], Verdict] = lambda: there.gate.check(*columns, **named)  # type: ignore[arg-type]  # noqa: E731
    far = check()
    stops = possible_stops(far)
    if stops is None or not far.safe:  # a limit, or the arm's own links
        return None
    reach = reach_of(there.gate.robot)
    states = np.concatenate([states_on(one, reach, _EVERY) for one in (*motion_of(chunk), *stops)])
    if not place_at(there, states, MARGIN + clearance):
        return None
    coal = with_extra_margin(second_checker(there.gate._current_guard().checker), clearance - 2.0 * _ACCURACY)
    if coal.first_contact(states) is not None:
        return None
    return check()


def place_at(there: Stage, states: Floats, distance: float) -> bool:
    """Move the obstacle until its distance and that of all else is ``distance`` (m); False where it cannot be."""
    world, shift = there.gate.world, 0.0
    placement = next(item.placement for item in world.scene.obstacles if item.name == there.near)
    for _ in range(_MOST_STEPS):  # it comes no nearer than it moves, so it never passes the distance
        moved = placement.copy()
        moved[:3, 3] -= shift * there.away
        try:
            world.put(there.near, moved)
        except SceneError:  # it stands in the base
            return False
        gap = least_gap(second_checker(there.gate._current_guard().checker), states)
        if gap - distance < _ACCURACY:
            return gap > distance - _ACCURACY
        shift += gap - distance
    return False


def least_gap(checker: CollisionChecker, states: Floats) -> float:
    """The smallest distance (m) of the checked pairs in states (n, dof), by coal where planes do not exclude it."""
    rotation, position = joint_placements(checker.chain, states)
    bounds = checker.bound.coarse(rotation, position)
    order, least = np.argsort(bounds, axis=None), np.inf
    for first in range(0, len(order), _BATCH):
        rows, pairs = np.unravel_index(order[first : first + _BATCH], bounds.shape)
        if bounds[rows[0], pairs[0]] >= least:
            break
        close = checker.bound.close(rotation, position, rows, pairs)
        nearest = np.argsort(close)[:_CLOSEST]
        nearest = nearest[close[nearest] < least]
        if len(nearest):
            gaps = checker.distances_in(rotation, position, rows[nearest], pairs[nearest])
            least = min(least, float(gaps.min()))
    return least
