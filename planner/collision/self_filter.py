"""Removal of the robot's own points from what sensors saw."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import Note
from planner.collision.bounding_volumes import hull_of
from planner.collision.bounds import CONVEX, ClearanceBound
from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.clouds import Points, Voxels, notes_on_clouds
from planner.robot.robot import Robot
from planner.robot.robot_in_scene import resolve_frames, state_seen
from planner.robot.scene import Scene
from planner.robot.shapes import Mesh, Obstacle, bounding_box
from planner.robot.solids import solid_of


def points_on_robot(robot: Robot, q: Floats, points: Floats, margin: float) -> Bools:
    """Return which ``points`` (n, 3) in the world are within ``margin`` (m) of the robot at ``q`` (dof,).

    Includes the payload. The distance is that of the proofs, to a micrometre.
    """
    rotation, position = joint_placements(Chain.from_arm(robot), np.asarray(q, dtype=float)[None])
    near, rows = np.zeros(len(points), dtype=bool), _find_around(robot, rotation, position, points, margin)
    if not len(rows):
        return near
    some = np.ascontiguousarray(points[rows])
    bound = ClearanceBound(World.from_scene(robot, Scene("empty"), frozenset()))
    near[rows] = bound.native.points_within(rotation, position, some, margin)
    for body in robot.bodies:  # distances are those of surfaces, and of the whole of a convex mesh
        if isinstance(body.shape, Mesh) and hull_of(body.shape)[1] >= CONVEX and (solid := solid_of(body.shape)):
            local = (some - position[body.joint, 0]) @ rotation[body.joint, 0]
            near[rows] |= solid.contains((local - body.placement[:3, 3]) @ body.placement[:3, :3])
    return near


def _find_around(robot: Robot, rotation: Floats, position: Floats, points: Floats, margin: float) -> Ints:
    """Return which points (n, 3) are within ``margin`` (m) of a box around balls about the bodies."""
    boxes = [(body, *bounding_box(body.shape)) for body in robot.bodies]
    middles = [body.placement[:3, :3] @ (0.5 * (low + high)) + body.placement[:3, 3] for body, low, high in boxes]
    joints = np.array([body.joint for body in robot.bodies], dtype=np.int64)
    placed = (rotation[joints, 0] @ np.reshape(middles, (-1, 3, 1)))[..., 0] + position[joints, 0]
    reach = np.reshape([0.5 * np.linalg.norm(high - low) + margin + 1e-6 for _, low, high in boxes], (-1, 1))
    low, high = (placed - reach).min(axis=0, initial=np.inf), (placed + reach).max(axis=0, initial=-np.inf)
    return np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))


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


def prepare_scene(scene: Scene, robot: Robot) -> Scene:
    """Return the scene in its own frame, without what sensors saw of the robot and what it carries.

    Notes count what is left out. Raises :class:`SceneError` for an unknown frame, or a state that is not joint values.
    """
    scene = resolve_frames(scene, robot)
    if not any(item.seen_at for item in scene.obstacles):
        return scene
    others, stale = [], notes_on_clouds(scene.obstacles)
    notes = [note for note in scene.notes if note not in stale]
    for item in scene.obstacles:
        margin, before = item.self_filter, _count(item)
        q = state_seen(item, robot, scene) if item.seen_at else None
        rest = (item,) if q is None else without_robot((replace(item, seen_at=""),), robot, q, margin)
        others += rest
        if own := before - sum(map(_count, rest)):
            text = f"{own} of {before} points or cells of '{item.name}' are left out: they are within "
            notes.append(Note(f"{text}{1e3 * margin:g} mm of the robot at {item.seen_at}.", grave=False))
    return replace(scene, obstacles=tuple(others), notes=tuple(notes))


def _count(item: Obstacle) -> int:
    """Return the number of points or solid cells; 0 for other shapes."""
    shape = item.shape
    return len(shape.vertices) if isinstance(shape, Points) else int(np.count_nonzero(getattr(shape, "occupied", ())))
