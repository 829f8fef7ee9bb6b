"""Boxes that move within their speed limits while the arm runs its trajectory: none may touch before the horizon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.collision.checker import CollisionChecker
from planner.collision.moving_prover import TimedProver
from planner.kinematics.forward import joint_placements
from planner.models.moving import KnownMotion, MovingObstacle
from planner.models.poses import pose
from planner.models.shapes import Box, Obstacle, farthest
from planner.trajectory.moving_obstacles import certified_horizon, first_touch_in_time
from planner.trajectory.trajectory import Trajectory

_BOXES, _KNOTS = 3, 20  # boxes a run, and changes of course of each
_SIZE, _SPEED = (0.05, 0.2), (0.05, 0.6)  # m, m/s
_NEAR, _APART = 0.7, 0.05  # m: how far from the arm boxes begin at most and at least
_AFTER = 2.0  # s beyond the horizon that are simulated
_STEP = 5e-3  # m of motion between two looks
_TURNING = 0.3  # share of its speed that a box that turns spends on it


@dataclass(frozen=True)
class Simulated:
    """Runs in which boxes moved, the contacts seen before the certified horizon and after it, and the median horizon.

    Those after it, in s beyond which nothing is claimed, show that the boxes do come for the arm.
    """

    runs: int
    before: int
    after: int
    horizon: float


def simulate(checker: CollisionChecker, trajectory: Trajectory, runs: int, seed: int) -> Simulated:
    """Let boxes move about an arm that runs its trajectory: every other one comes for a joint, the rest at random."""
    rng, horizons, before, after = np.random.default_rng(seed), [], 0, 0
    for run in range(runs):
        boxes = _draw(checker, trajectory, rng)
        until = certified_horizon(trajectory, TimedProver(checker, limited=boxes))
        horizons.append(until)
        end = min(until, float(trajectory.times[-1])) + _AFTER
        moving = [_sent(checker, trajectory, box, end, run % 2 == 0, rng) for box in boxes]
        found = first_touch_in_time(_until(trajectory, end), checker, moving, _STEP)
        before += found is not None and found[0] < until
        after += found is not None and found[0] >= until
    return Simulated(runs, before, after, float(np.median(horizons)))


def _until(trajectory: Trajectory, end: float) -> Trajectory:
    """The trajectory as far as ``end`` (s), by lines between many moments; beyond its own end the arm stands."""
    times = np.linspace(0.0, end, int(np.ceil(end / 0.01)) + 1)
    return Trajectory.through(trajectory.joints, times, trajectory.at(times))


def _draw(checker: CollisionChecker, trajectory: Trajectory, rng: np.random.Generator) -> list[Obstacle]:
    """Boxes near the arm at its start, each with a speed limit, that it does not touch."""
    joints, boxes = _joints(checker, trajectory, 0.0), []
    while len(boxes) < _BOXES:
        place = joints[int(rng.integers(len(joints)))] + rng.uniform(-_NEAR, _NEAR, 3)
        size, limit = rng.uniform(*_SIZE, 3), float(rng.uniform(*_SPEED))
        box = Obstacle(
            f"box {len(boxes)}",
            Box((float(size[0]), float(size[1]), float(size[2]))),
            pose(place.tolist(), rng.uniform(-3, 3, 3).tolist()),
            speed_limit=limit,
        )
        if TimedProver(checker, limited=[box]).gaps(trajectory.at(0.0)[0]).min() > _APART:
            boxes.append(box)
    return boxes


def _sent(
    checker: CollisionChecker, trajectory: Trajectory, box: Obstacle, end: float, hunts: bool, rng: np.random.Generator
) -> MovingObstacle:
    """The box on a way of its own, no point of it quicker than its limit."""
    times, seconds = np.linspace(0.0, end, _KNOTS), end / (_KNOTS - 1)
    share = 0.0 if hunts else _TURNING
    poses, joint = [np.array(box.placement)], int(rng.integers(checker.robot.dof))
    angle = share * box.speed_limit * seconds / farthest(box.shape, np.eye(4))
    for t in times[1:]:
        last = poses[-1]
        aim = _joints(checker, trajectory, t)[joint] - last[:3, 3] if hunts else rng.normal(size=3)
        far, away = (1.0 - share) * box.speed_limit * seconds, float(np.linalg.norm(aim))
        place = last[:3, 3] + aim * (far / max(away, far if hunts else 1e-9))
        turn = pose(rpy=[0.0, 0.0, angle])[:3, :3]
        poses.append(np.block([[last[:3, :3] @ turn, place[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]]))
    return MovingObstacle(box.name, box.shape, KnownMotion(times, poses))


def _joints(checker: CollisionChecker, trajectory: Trajectory, t: float) -> Floats:
    """Positions (dof, 3) of the joints at ``t`` s."""
    return joint_placements(checker.chain, trajectory.at(t))[1][1:, 0]
