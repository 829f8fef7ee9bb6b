"""Chunks of joint targets as a policy or a hand gives them, and thin obstacles where they pass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.shapes import Box, Cylinder, Obstacle, Shape, Sphere

Rng = np.random.Generator
KINDS = ("lines", "cubics", "quintics")


@dataclass(frozen=True, eq=False)
class Chunk:
    """``knots`` (k + 1, 3, dof) positions, velocities, accelerations at ``times`` (k + 1,) s; at 0 s those of now."""

    kind: str
    times: Floats
    knots: Floats

    def arguments(self) -> tuple[tuple[Floats, ...], dict[str, object]]:
        """What :meth:`planner.Gate.check` is given."""
        columns = tuple(self.knots[1:, order] for order in range(KINDS.index(self.kind) + 1))
        return columns, {"times": self.times[1:], "state": tuple(self.knots[0])}


def random_chunk(robot: Robot, kind: str, steps: int, seconds: float, rng: Rng, size: float = 0.12) -> Chunk:
    """A smooth motion of ``steps`` targets: sines of random speeds from a random state well within limits."""
    times = np.linspace(0.0, seconds, steps + 1)
    lower, upper = np.where(robot.continuous, -3.0, robot.lower), np.where(robot.continuous, 3.0, robot.upper)
    start = 0.5 * (lower + upper) + 0.5 * (upper - lower) * rng.uniform(-0.75, 0.75, robot.dof)
    speed = rng.uniform(1.0, 4.0, (3, robot.dof))
    height, phase = rng.normal(0.0, 2.0 * size, (3, robot.dof)) / speed, rng.uniform(0.0, 2.0 * np.pi, (3, robot.dof))
    return sine_chunk(kind, times, start, speed, height, phase)


def sine_chunk(kind: str, times: Floats, start: Floats, speed: Floats, height: Floats, phase: Floats) -> Chunk:
    """A motion from ``start`` (dof,): the sum of sines whose numbers are rows (k, dof)."""
    angle = speed[:, None] * times[:, None] + phase[:, None]
    waves = (
        np.sin(angle) - np.sin(phase)[:, None],
        speed[:, None] * np.cos(angle),
        -(speed[:, None] ** 2) * np.sin(angle),
    )
    knots = np.stack([(height[:, None] * wave).sum(axis=0) for wave in waves], axis=1)
    knots[:, 0] += start
    return Chunk(kind, times, knots)


def clutter(count: int, rng: Rng) -> tuple[Obstacle, ...]:
    """Boxes of 4 to 20 cm around an arm."""
    made = []
    for k in range(count):
        radius, angle, height = rng.uniform(0.35, 0.75), rng.uniform(-np.pi, np.pi), rng.uniform(0.1, 0.9)
        place = pose([radius * np.cos(angle), radius * np.sin(angle), height], rpy=rng.uniform(-1.0, 1.0, 3).tolist())
        made.append(Obstacle(f"box{k}", Box(tuple(rng.uniform(0.04, 0.2, 3))), place))
    return tuple(made)


def thin_obstacle(robot: Robot, near: Floats, rng: Rng) -> Obstacle:
    """A wall, pole or ball of a few millimetres about where a link is in a configuration (dof,)."""
    body = robot.bodies[int(rng.integers(len(robot.bodies) // 2, len(robot.bodies)))]
    rotation, position = joint_placements(Chain.from_arm(robot), near[None])
    at = position[body.joint, 0] + rotation[body.joint, 0] @ body.placement[:3, 3]
    thin, long = rng.uniform(5e-4, 5e-3), rng.uniform(0.05, 0.2)
    shapes: list[Shape] = [Box((thin, long, long)), Cylinder(thin, long), Sphere(thin)]
    offset = rng.normal(0.0, rng.choice([0.01, 0.08]), 3)
    return Obstacle(
        "thin", shapes[int(rng.integers(3))], pose((at + offset).tolist(), rpy=rng.uniform(-np.pi, np.pi, 3).tolist())
    )
