"""Thin obstacles where an arm sweeps: walls, poles and windows, and edges with free ends that pass through or near."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker, is_free
from planner.kinematics.forward import joint_placements
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Cylinder, Obstacle, Shape, corners

KINDS = ("wall", "pole", "window")

EDGES_PER_SCENE = 5
_MOTION = (0.3, 1.2)  # m that some point of the arm moves at most on an edge
_OFFSET = (0.005, 0.06)  # m: standard deviation of the obstacle's distance from the arm, drawn each time
_TURN = 0.06  # rad: standard deviation between the ends of the edges of one scene
_TRIES = 200


@dataclass(frozen=True, eq=False)
class ThinCase:
    """A scene with one thin obstacle, and edges ``start`` + s ``delta``, s in [0, 1], (n, dof) each, with free ends."""

    scene: Scene
    start: Floats
    delta: Floats


def thin_case(alone: CollisionChecker, kind: str, thickness: float, rng: np.random.Generator) -> ThinCase:
    """One obstacle of ``kind``, ``thickness`` m thick, where an edge of the arm passes, and more edges near that one.

    ``alone`` checks the robot in an empty scene. A random short edge is drawn, then a point of a link that moves
    along it, in the middle part of the edge; the obstacle is put there at a random pose, a little off. Obstacles that
    the edge's ends touch are drawn again.
    """
    robot = alone.world.robot
    while True:
        start, delta = _edge(alone, rng)
        where = _point_on_the_way(alone, start, delta, rng)
        for _ in range(10):
            items = _obstacle(kind, thickness, where + rng.normal(0.0, rng.uniform(*_OFFSET), 3), rng)
            scene = Scene(f"thin {kind}", items)
            checker = make_checker(robot, scene, "coal")
            if is_free(checker, start) and is_free(checker, start + delta):
                edges = _edges_nearby(checker, start, delta, rng)
                return ThinCase(scene, edges[0], edges[1])


def _edge(alone: CollisionChecker, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """A random motion within limits whose ends and middle are free, of a random length."""
    robot, reach = alone.world.robot, alone.world.reach
    while True:
        middle = rng.uniform(robot.lower, robot.upper)
        delta = rng.normal(size=robot.dof)
        delta *= rng.uniform(*_MOTION) / float(reach.motion(delta[None]).max())
        ends = middle + np.outer([-0.5, 0.0, 0.5], delta)
        if _within_limits(robot, ends) and alone.first_contact(ends) is None:
            return ends[0], delta


def _within_limits(robot: Robot, q: Floats) -> bool:
    return bool((robot.continuous | ((q >= robot.lower) & (q <= robot.upper))).all())


def _point_on_the_way(alone: CollisionChecker, start: Floats, delta: Floats, rng: np.random.Generator) -> Floats:
    """A point (3,) of a link beyond the arm's middle, between a fifth and four fifths of the edge."""
    bodies = [body for body in alone.world.bodies if 2 * body.joint > alone.world.robot.dof]  # the faster half
    body = bodies[rng.integers(len(bodies))]
    rotation, position = joint_placements(alone.chain, (start + rng.uniform(0.2, 0.8) * delta)[None])
    points, _ = corners(body.shape)
    local = body.placement[:3, :3] @ points[rng.integers(len(points))] + body.placement[:3, 3]
    return position[body.joint, 0] + rotation[body.joint, 0] @ local


def _edges_nearby(
    checker: CollisionChecker, start: Floats, delta: Floats, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """The edge and others near it, each with free ends within limits; the edge again where none is found."""
    robot = checker.robot
    starts, deltas = [start], [delta]
    for _ in range(_TRIES):
        if len(starts) == EDGES_PER_SCENE:
            break
        ends = np.array([start, start + delta]) + rng.normal(0.0, _TURN, (2, robot.dof))
        if _within_limits(robot, ends) and is_free(checker, ends[0]) and is_free(checker, ends[1]):
            starts.append(ends[0])
            deltas.append(ends[1] - ends[0])
    return np.array(starts), np.array(deltas)


def _obstacle(kind: str, thickness: float, where: Floats, rng: np.random.Generator) -> tuple[Obstacle, ...]:
    """The shapes of one obstacle at a random pose, a random part of it at ``where``."""
    placement = pose(where.tolist(), quaternion=rng.normal(size=4).tolist())
    match kind:
        case "wall":
            wide, high = rng.uniform(0.05, 0.4, 2)
            parts = [(Box((wide, high, thickness)), 0.4 * rng.uniform(-1, 1, 2) * (wide, high))]
        case "pole":
            length = rng.uniform(0.1, 0.8)
            round_ = rng.random() < 0.5
            shape: Shape = Cylinder(0.5 * thickness, length) if round_ else Box((thickness, thickness, length))
            return (Obstacle("pole", shape, placement),)
        case _:
            parts = _frame(thickness, rng)
    return tuple(
        Obstacle(f"{kind} {k}", shape, placement @ pose((x, y, 0.0))) for k, (shape, (x, y)) in enumerate(parts)
    )


def _frame(thickness: float, rng: np.random.Generator) -> list[tuple[Box, Floats]]:
    """Four boards around an opening, in the plane of the first two axes; where the opening lies is random too."""
    wide, high = rng.uniform(0.1, 0.35, 2)
    rim = rng.uniform(0.02, 0.1)
    centre = rng.uniform(-1, 1, 2) * (0.5 * wide + rim, 0.5 * high + rim)
    side, board = Box((rim, high, thickness)), Box((wide + 2 * rim, rim, thickness))
    across, up = 0.5 * (wide + rim), 0.5 * (high + rim)
    places = ((side, (-across, 0.0)), (side, (across, 0.0)), (board, (0.0, -up)), (board, (0.0, up)))
    return [(shape, centre + place) for shape, place in places]
