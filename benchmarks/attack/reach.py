"""The bound on how far a segment moves any point of a body, against points that are moved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.attack.cases import point_on
from benchmarks.attack.climb import climb
from planner.base.arrays import Floats
from planner.base.progress import Progress
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.reach import Reach
from planner.robot.robot import Robot
from planner.robot.shapes import Mesh

_POINTS = 60  # of each body
_LENGTHS = (-3.0, 0.5)  # decimal exponents of the motion of a segment (rad, m)

Motion = tuple[Floats, Floats]  # start and end (dof,) of a segment


@dataclass
class Moved:
    """Segments tried; the largest motion minus bound (m), the largest share of its bound that a motion takes."""

    tried: int = 0
    over: float = -np.inf
    share: float = 0.0
    found: dict[str, Any] = field(default_factory=dict)


def attack_reach(name: str, tries: int, rng: np.random.Generator, progress: Progress) -> Moved | None:
    """The worst of ``tries`` segments of a robot; None where stopped."""
    robot, moved = Robot.load(name), Moved()
    judge = _Judge(robot, moved, rng)
    if not len(robot.bodies):
        return moved
    done = climb(
        tries, rng, lambda rng: _begin(robot, rng), lambda m, size, rng: _step(robot, m, size, rng), judge, progress
    )
    return moved if done else None


def _begin(robot: Robot, rng: np.random.Generator) -> Motion:
    low, high = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    start = rng.uniform(low, high)
    delta = rng.normal(size=robot.dof) * (rng.random(robot.dof) < rng.random())
    delta *= 10.0 ** rng.uniform(*_LENGTHS) / max(float(np.linalg.norm(delta)), 1e-9)
    return start, np.clip(start + delta, low, high)


def _step(robot: Robot, motion: Motion, size: float, rng: np.random.Generator) -> Motion:
    """Both ends moved, so that the segment stays short or long, or the segment made another."""
    start, end = motion
    delta = end - start
    if rng.random() < 0.5:
        start = start + size * rng.normal(size=robot.dof) * (rng.random(robot.dof) < 0.5)
    else:
        delta = delta * (1.0 + size * rng.normal(size=robot.dof))
    low, high = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    start = np.clip(start, low, high)
    return start, np.clip(start + delta, low, high)


class _Judge:
    """Scores motions: the largest share of its bound that a point takes."""

    def __init__(self, robot: Robot, moved: Moved, rng: np.random.Generator) -> None:
        self.robot, self.moved, self.chain, self.reach = robot, moved, Chain.of(robot), Reach.of(robot)
        self.points = [
            points_of(body.shape, rng) @ body.placement[:3, :3].T + body.placement[:3, 3] for body in robot.bodies
        ]

    def __call__(self, motions: Sequence[Motion]) -> list[float]:
        return [self._share(*motion) for motion in motions]

    def _share(self, start: Floats, end: Floats) -> float:
        rotation, position = joint_placements(self.chain, np.array([start, end]))
        bounds, best = self.reach.motion((end - start)[None])[0], 0.0
        self.moved.tried += 1
        for body, points, bound in zip(self.robot.bodies, self.points, bounds, strict=True):
            turned = points @ rotation[body.joint].transpose(0, 2, 1) + position[body.joint][:, None]
            motion = float(np.linalg.norm(turned[1] - turned[0], axis=1).max())
            if motion - bound > self.moved.over:
                self.moved.over = motion - float(bound)
                self.moved.found = {"body": body.name, "start": start.tolist(), "end": end.tolist()}
            if bound > 1e-6:
                best = max(best, motion / float(bound))
        self.moved.share = max(self.moved.share, best)
        return best


def points_of(shape: Any, rng: np.random.Generator) -> Floats:
    """Points (k, 3) of a shape, the outermost among them."""
    if isinstance(shape, Mesh):
        away = rng.normal(size=(3, _POINTS))
        return shape.vertices[np.unique((shape.vertices @ away).argmax(axis=0))]
    return np.array([point_on(shape, rng) for _ in range(4 * _POINTS)])
