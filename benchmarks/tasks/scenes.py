"""Seeded scenes for tasks: boxes on a table, in a bin, on a shelf, among others; one is to be put on a board."""

from __future__ import annotations

import numpy as np

from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Cylinder, Obstacle, Shape
from planner.tasks.task import Move, Pick, Place, Task

KINDS = ("table", "bin", "shelf")
_TABLE = Obstacle("table", Box((0.9, 1.6, 0.04)), pose((0.6, 0.0, -0.02)))
_TARGET = Obstacle("target", Box((0.3, 0.3, 0.1)), pose((0.45, 0.45, 0.05)))
_REGION = (0.3, 0.3), (0.6, 0.6)


def seeded_task(kind: str, number: int, seed: int) -> Task:
    """The Panda takes the thing of a seeded scene, puts it on the board and goes home."""
    scene = seeded_scene(kind, number, seed)
    return Task("panda", scene, (Pick("thing"), Place("thing", "target", _REGION), Move("home")), name=scene.name)


def seeded_scene(kind: str, number: int, seed: int) -> Scene:
    """A thing at a random place, among up to four others."""
    rng = np.random.default_rng([seed, number, KINDS.index(kind)])
    shape, half = _thing(rng)
    around, centre, spread, floor = _surroundings(kind)
    at = centre + rng.uniform(-spread, spread)
    thing = Obstacle("thing", shape, pose((*at, floor + half), rpy=(0.0, 0.0, rng.uniform(0, 2 * np.pi))))
    others = []
    for k in range(rng.integers(0, 5)):
        size = rng.uniform((0.04, 0.04, 0.05), (0.09, 0.09, 0.15))
        place = centre + rng.uniform(-spread, spread)
        apart = np.linalg.norm(place - at)
        if apart > 0.11 and all(np.linalg.norm(place - other.placement[:2, 3]) > 0.13 for other in others):
            turn = (0.0, 0.0, rng.uniform(0, 2 * np.pi))
            others.append(Obstacle(f"other {k}", Box(tuple(size)), pose((*place, floor + size[2] / 2), rpy=turn)))
    return Scene(f"{kind} {number}", (_TABLE, _TARGET, *around, *others, thing))


def _thing(rng: np.random.Generator) -> tuple[Shape, float]:
    """A box or a cylinder that the gripper can hold, and half its height."""
    if rng.random() < 0.5:
        size = rng.uniform((0.03, 0.03, 0.05), (0.065, 0.12, 0.16))
        return Box(tuple(size)), size[2] / 2
    radius, length = rng.uniform((0.015, 0.06), (0.035, 0.16))
    return Cylinder(radius, length), length / 2


def _surroundings(kind: str) -> tuple[tuple[Obstacle, ...], np.ndarray, np.ndarray, float]:
    """Walls, the middle of where things are and half the size of that (2,), and on which height."""
    if kind == "table":
        return (), np.array([0.5, -0.25]), np.array([0.15, 0.25]), 0.0
    if kind == "bin":
        long, high, x, y = 0.4, 0.12, 0.5, -0.3
        walls = [
            Obstacle(f"wall {k}", Box(size), pose((x + dx, y + dy, high / 2)))
            for k, (size, dx, dy) in enumerate(
                [
                    ((0.02, long, high), -long / 2, 0.0),
                    ((0.02, long, high), long / 2, 0.0),
                    ((long, 0.02, high), 0.0, -long / 2),
                    ((long, 0.02, high), 0.0, long / 2),
                ]
            )
        ]
        return tuple(walls), np.array([x, y]), np.array([0.1, 0.1]), 0.0
    board = 0.30
    parts = [
        Obstacle("board", Box((0.3, 0.5, 0.02)), pose((0.62, -0.35, board - 0.01))),
        Obstacle("roof", Box((0.3, 0.5, 0.02)), pose((0.62, -0.35, board + 0.4))),
        Obstacle("side", Box((0.3, 0.02, 0.72)), pose((0.62, -0.61, 0.36))),
        Obstacle("back", Box((0.02, 0.5, 0.72)), pose((0.78, -0.35, 0.36))),
    ]
    return tuple(parts), np.array([0.57, -0.33]), np.array([0.06, 0.15]), board
