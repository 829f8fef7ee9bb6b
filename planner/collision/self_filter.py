"""Removal of the robot's own points from a cloud."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from planner.base.arrays import Bools, Floats
from planner.collision.bounding_volumes import hull_of
from planner.collision.bounds import ClearanceBound
from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.clouds import Points, Voxels
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Mesh, Obstacle
from planner.robot.solids import solid_of


def points_on_robot(robot: Robot, q: Floats, points: Floats, margin: float) -> Bools:
    """Return which ``points`` (n, 3) in the world are within ``margin`` (m) of the robot at ``q`` (dof,).

    Includes the payload. The distance is that of the proofs, to a micrometre.
    """
    rotation, position = joint_placements(Chain.from_arm(robot), np.asarray(q, dtype=float)[None])
    bound = ClearanceBound(World.from_scene(robot, Scene("empty"), frozenset()))
    near = bound.native.points_within(rotation, position, np.ascontiguousarray(points), margin)
    for body in robot.bodies:  # distances are those of surfaces, and of the whole of a convex mesh
        if isinstance(body.shape, Mesh) and hull_of(body.shape)[1] > 0 and (solid := solid_of(body.shape)):
            rows = np.flatnonzero(~near)
            local = (points[rows] - position[body.joint, 0]) @ rotation[body.joint, 0]
            near[rows] = solid.contains((local - body.placement[:3, 3]) @ body.placement[:3, :3])
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
