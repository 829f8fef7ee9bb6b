"""Looks at finished paths and motions by the collision library that has not planned, and how a first path is timed."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence

import numpy as np

from planner.base.arrays import Floats
from planner.collision import BACKENDS, make_checker
from planner.collision.checker import CollisionChecker
from planner.collision.recheck import sample_contacts
from planner.roadmap.first_path import FIRST_PATH
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.measure import path_contact
from planner.trajectory.trajectory import Trajectory

STEP = 1e-4  # m of motion between two looks at a motion


def other_checker(robot: Robot, scene: Scene, collision: str) -> CollisionChecker:
    """A checker by the library that has not planned, which shares no verdict with the other."""
    return make_checker(robot, scene, next(name for name in BACKENDS if name != collision))


def path_contacts(checker: CollisionChecker, path: Floats) -> list[str]:
    """For each segment of the path that touches something at a millimetre of motion: where, and what."""
    segments = itertools.pairwise(path) if len(path) > 1 else [(path[0], path[0])]
    found = []
    for k, (a, b) in enumerate(segments):
        contact = path_contact(checker, np.array([a, b]))
        if contact is not None:
            found.append(f"segment {k} at {contact.s:.4f}: {contact.contact}")
    return found


def motion_contact(motion: Trajectory, judge: CollisionChecker) -> str:
    """The first contact at 0.1 mm of motion, empty where there is none."""
    seen = sample_contacts(judge, motion.coefficients, STEP)
    if seen is None:
        return ""
    t = motion.times[seen.piece] + seen.s * motion.seconds[seen.piece]
    return f"{seen.contact} at {t:.4f} s"


def largest_share(trajectory: Trajectory, limits: MotionLimits, kinds: Sequence[str] = KINDS) -> float:
    """The largest share of any limit of these kinds that is used, by the exact extrema of the pieces."""
    return max(trajectory.worst(order, getattr(limits, kind))[0] for order, kind in enumerate(kinds, start=1))


class FirstPath:
    """A listener to the progress of a plan, which notes after how many seconds the first path is proven."""

    def __init__(self) -> None:
        self.begin = time.perf_counter()
        self.seconds: float | None = None

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage == FIRST_PATH and done >= total and self.seconds is None:
            self.seconds = time.perf_counter() - self.begin
