"""Where an object can stand: poses that are given, or sampled in a region of a box's top; and what it rests on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import choices
from planner.base.yamlfile import nearest
from planner.collision.checker import CollisionChecker
from planner.robot.poses import pose
from planner.robot.robot import with_carried
from planner.robot.shapes import Box, Capsule, Carried, Cylinder, Mesh, Obstacle, Shape, Sphere
from planner.tasks.file import Region, TaskError
from planner.tasks.modes import Place

GAP = 1e-3  # m beyond the margin, between a sampled placement and the surface: what stands there touches nothing
REST = 5e-3  # m: what is no farther beneath an object carries it
_LEVEL = 1e-6  # of a direction's components
_TRIES = 50  # points per sample that is wanted
_STEPS = 1 / 1.2207440846057596 ** np.arange(1, 4)  # of the additive sequence in (x, y, turn) that covers most evenly


def extent(shape: Shape, rotation: Floats) -> tuple[Floats, Floats]:
    """The lowest and highest coordinates (3,) of a turned shape about its own origin, exact."""
    match shape:
        case Box(size):
            half = np.abs(rotation) @ (0.5 * np.array(size))
        case Sphere(radius):
            half = np.full(3, radius)
        case Cylinder(radius, length):
            axis = rotation[:, 2]
            half = 0.5 * length * np.abs(axis) + radius * np.sqrt(np.maximum(1 - axis**2, 0.0))
        case Capsule(radius, length):
            half = 0.5 * length * np.abs(rotation[:, 2]) + radius
        case Mesh():
            points = shape.vertices @ rotation.T
            return points.min(axis=0) - shape.radius, points.max(axis=0) + shape.radius
    return -half, half


def in_region(item: Obstacle, region: Region, boards: Iterable[Obstacle], margin: float) -> list[Place]:
    """Places of an object on the top of a box, as it stands in the scene but turned about the vertical.

    All of it lies within the region, ``GAP`` beyond the margin above the top. Raises :class:`TaskError` for a region
    that is not on a level top, or smaller than the object.
    """
    board = _board(region.on, list(boards))
    low, high = np.min(region.corners, axis=0), np.max(region.corners, axis=0)
    top = _level_of_top(board, low, high)
    upright, found = item.placement[:3, :3], []
    for k in range(_TRIES * region.samples):
        at = np.mod(0.5 + (k + 1) * _STEPS, 1.0)
        turn = pose(rpy=(0.0, 0.0, 2 * np.pi * at[2]))[:3, :3] @ upright
        least, most = extent(item.shape, turn)
        room = high - low - (most - least)[:2]
        if (room < 0).any():
            continue
        matrix = np.eye(4)
        matrix[:3, :3] = turn
        matrix[:2, 3] = low - least[:2] + at[:2] * room
        matrix[2, 3] = top - least[2] + margin + GAP
        found.append(Place(item.name, matrix, (board.name,)))
        if len(found) == region.samples:
            break
    if not found:
        size = " x ".join(f"{side:.3g}" for side in high - low)
        raise TaskError(f"the region on '{board.name}' ({size} m) is smaller than '{item.name}': give a larger one.")
    return found


def _board(name: str, boards: list[Obstacle]) -> Obstacle:
    board = next((each for each in boards if each.name == name), None)
    if board is None:
        names = [each.name for each in boards]
        raise TaskError(f"'{name}'{nearest(name, names)} is nothing to put on; what stands still is {choices(names)}.")
    if not isinstance(board.shape, Box):
        raise TaskError(f"'{name}' is no box, and regions are of a box's top: give a 'pose' in place of 'on' and 'at'.")
    return board


def _level_of_top(board: Obstacle, low: Floats, high: Floats) -> float:
    """How high (m) the top of a box is; :class:`TaskError` where it is not level, or does not hold the region."""
    assert isinstance(board.shape, Box)
    turn, half = board.placement[:3, :3], 0.5 * np.array(board.shape.size)
    up = int(np.abs(turn[2]).argmax())
    if abs(turn[2, up]) < 1.0 - _LEVEL:
        raise TaskError(f"the top of '{board.name}' is not level: give a 'pose' in place of 'on' and 'at'.")
    corners = np.array([[x, y, 0.0] for x in (low[0], high[0]) for y in (low[1], high[1])])
    corners[:, 2] = board.placement[2, 3]
    inside = np.abs((corners - board.placement[:3, 3]) @ turn) <= half + 1e-9
    if not inside.all():
        least, most = (end + board.placement[:3, 3] for end in extent(board.shape, turn))
        spans = f"x {least[0]:.3g} to {most[0]:.3g}, y {least[1]:.3g} to {most[1]:.3g}"
        raise TaskError(f"the region reaches beyond the top of '{board.name}' ({spans} m): keep it inside.")
    return float(board.placement[2, 3] + half[up])


def standing(item: Obstacle, placement: Floats, among: CollisionChecker, others: tuple[Obstacle, ...] = ()) -> Place:
    """An object at ``placement``, and what it rests on: what it would touch were it ``REST`` lower."""
    lower = np.array(placement)
    lower[2, 3] -= REST + among.world.margin
    return Place(item.name, np.array(placement), _touched(item, lower, among, others))


def at_pose(item: Obstacle, placement: Floats, among: CollisionChecker) -> Place:
    """The place at a pose that is given; :class:`TaskError` where it lies inside something, or in the air."""
    where, place = ", ".join(f"{value:g}" for value in placement[:3, 3]), standing(item, placement, among)
    lifted = np.array(placement)
    lifted[2, 3] += GAP + among.world.margin
    hit = [name for name in _touched(item, lifted, among) if name in place.supports]  # others are above it
    if hit:
        raise TaskError(
            f"'{item.name}' cannot stand at ({where}) m: it would lie inside '{hit[0]}'; choose another pose."
        )
    if not place.supports:
        raise TaskError(
            f"'{item.name}' would stand in the air at ({where}) m: nothing is within {1e3 * REST:g} mm beneath it; "
            "lower it onto something."
        )
    return place


def _touched(
    item: Obstacle, placement: Floats, among: CollisionChecker, others: tuple[Obstacle, ...] = ()
) -> tuple[str, ...]:
    """What an object touches at ``placement``, or comes closer to than the margin: fixed things, and ``others``."""
    root = among.robot.model.frames[0]
    held = Carried(root.name, item.name, item.shape, np.linalg.inv(root.placement.homogeneous) @ placement)
    robot = with_carried(among.robot, [held])
    scene = replace(among.world.scene, obstacles=(*among.world.obstacles, *others))
    checker = type(among)(among.world.among(scene, robot), among)
    count = len(scene.obstacles)
    near = checker.gaps(np.zeros(robot.dof), (len(robot.bodies) - 1) * count + np.arange(count)) <= among.world.margin
    return tuple(each.object for each, close in zip(scene.obstacles, near, strict=True) if close)
