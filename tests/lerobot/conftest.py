"""An SO-101 at a wall, its gate, and a clock that a test moves."""

from collections.abc import Callable

import numpy as np
import pytest

from planner.lerobot import ActionFilter
from planner.problem.request import WorldRequest
from planner.robot.poses import pose
from planner.robot.scene import Obstacle, Scene
from planner.robot.shapes import Box
from planner.session.gate import Gate
from planner.session.live_world import LiveWorld

NAMES = [
    f"{joint}.pos" for joint in ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")
]
FPS = 30.0
Make = Callable[..., ActionFilter]


class Clock:
    """The time of an observation, one period after the other."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        self.now += 1.0 / FPS
        return self.now


@pytest.fixture(scope="package")
def gate() -> Gate:
    """The arm turns into a wall at its left: at a pan of about -0.6 rad."""
    wall = Obstacle("wall", Box((0.5, 0.02, 0.6)), pose([0.3, 0.2, 0.3]))
    return Gate(LiveWorld(WorldRequest("so101", Scene("wall", (wall,)))))


@pytest.fixture
def make(gate: Gate) -> Make:
    return lambda **options: ActionFilter(gate, NAMES, fps=FPS, clock=Clock(), **options)


def chunk_to(pan: float, count: int = 30, begin: float = 0.0) -> np.ndarray:
    """Actions (1, count, 6) in degrees that turn the pan evenly, while the gripper opens from 0 to 100."""
    rows = np.zeros((1, count, 6))
    rows[0, :, 0] = begin + (pan - begin) * np.arange(1, count + 1) / count
    rows[0, :, 5] = 100.0 * np.arange(1, count + 1) / count
    return rows
