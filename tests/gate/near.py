"""A wall that a link of the planar arm passes at a given distance."""

from __future__ import annotations

import numpy as np

from planner.collision import make_checker
from planner.gate.gate import Gate
from planner.models.poses import pose
from planner.models.scene import Scene
from planner.models.shapes import Box, Obstacle
from tests.worlds import load


def beside(gap: float) -> Gate:
    """A plate above the plane that the arm moves in, ``gap`` (m) away from its links all along."""
    robot = load("planar_2r")
    high = 1.0
    plate = Obstacle("plate", Box((3.0, 3.0, 0.02)), pose([0.0, 0.0, high]))
    judge = make_checker(robot, Scene("x", (plate,)), "coal")
    moving = np.flatnonzero([body.joint > 0 for body in robot.bodies])
    rotation, position = judge.chain.native.placements(np.array([[0.3, 0.4]]))
    away = judge.distances(rotation[:, 0], position[:, 0], moving).min()
    plate = Obstacle("plate", Box((3.0, 3.0, 0.02)), pose([0.0, 0.0, high - float(away) + gap]))
    allowed = frozenset(frozenset((body.link, "plate")) for body in robot.bodies if body.joint == 0)
    return Gate(robot, Scene("x", (plate,), allowed=allowed))
