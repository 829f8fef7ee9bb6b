"""Removal of the robot's own points from a cloud."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from planner.base.arrays import Bools, Floats
from planner.collision.bounding_volumes import sphere_cover
from planner.collision.bounds import ClearanceBound
from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.clouds import Points, Voxels
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Mesh, Obstacle, Sphere
from planner.robot.solids import solid_of

_SPHERES = 24  # around a body, to find which points may be near


def points_on_robot(robot: Robot, q: Floats, points: Floats, margin: float) -> Bools:
    """Return which ``points`` (n, 3) in the world are within ``margin`` (m) of the robot at ``q`` (dof,).

    Includes the payload. The distance is that of the proofs, to a micrometre.
    """
    rotation, position = joint_placements(Chain.from_arm(robot), np.asarray(q, dtype=float)[None])
    near = np.zeros(len(points), dtype=bool)
    for body in robot.bodies:
        cover = sphere_cover(body.shape, _SPHERES)
        turn, at = rotation[body.joint, 0], position[body.joint, 0]
        for centre, radius in zip(cover.centres, cover.radii, strict=True):
            middle = turn @ (body.placement[:3, :3] @ centre + body.placement[:3, 3]) + at
            near |= np.linalg.norm(points - middle, axis=1) <= radius + margin
    rows = np.flatnonzero(near)
    if not len(rows):
        return near
    balls = tuple(Obstacle(f"{k}", Sphere(margin), pose(points[k])) for k in rows)
    world = World.from_scene(robot, Scene("points", balls), frozenset())
    pairs = np.arange(len(robot.bodies) * len(rows))
    gaps = ClearanceBound(world).close(rotation, position, np.zeros_like(pairs), pairs, 1e-6)
    near[rows] = (gaps.reshape(len(robot.bodies), -1) <= 0).any(axis=0)
    for body in robot.bodies:
        if isinstance(body.shape, Mesh) and (solid := solid_of(body.shape)):
            local = (points[rows] - position[body.joint, 0]) @ rotation[body.joint, 0]
            near[rows] |= solid.contains((local - body.placement[:3, 3]) @ body.placement[:3, :3])
    return near


def without_robot(seen: Iterable[Obstacle], robot: Robot, q: Floats, margin: float = 0.02) -> tuple[Obstacle, ...]:
    """Return obstacles without the robot, which stood at ``q`` (dof,) when a sensor saw them.

    Points within ``margin`` (m), noise and calibration error of a body are removed, and unknown cells that may be
    within ``margin``. Space that the robot hides stays unknown. A larger margin frees more space near the robot; with
    one that is too small, the robot starts in contact with itself.
    """
    remaining = []
    for item in seen:
        shape, (turn, at) = item.shape, (item.placement[:3, :3], item.placement[:3, 3])
        if isinstance(shape, Points):
            reach = margin + shape.noise + shape.calibration
            others = ~points_on_robot(robot, q, shape.vertices @ turn.T + at, reach)
            remaining += [replace(item, shape=shape.part(others))] if others.any() else []
        elif isinstance(shape, Voxels):
            cells = np.argwhere(shape.occupied)
            middles = (shape.origin + shape.pitch * (cells + 0.5)) @ turn.T + at
            solid = shape.occupied.copy()
            solid[tuple(cells.T)] = ~points_on_robot(robot, q, middles, margin + 0.87 * shape.pitch)  # half a diagonal
            remaining += [replace(item, shape=Voxels(solid, shape.pitch, shape.origin))] if solid.any() else []
        else:
            remaining.append(item)
    return tuple(remaining)
