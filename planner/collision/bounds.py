"""Lower bounds on pair distances: cheap ones by spheres, close ones by separating planes.

Spheres cover each body; each obstacle is a rounded box or a cylinder (a mesh: many boxes), and the distance between a
sphere and either has a closed form. Where that bound is too small, two parallel planes between the shapes give the
distance to a micrometre; a non-convex mesh is treated as its triangles. Neither bound exceeds the true distance, so a
pair that they clear needs no collision library.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from types import MappingProxyType

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen, product
from planner.base.cache import load_or_compute
from planner.collision.bounding_volumes import Spheres, box_cover, hull_of, sphere_cover
from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements, travel
from planner.native.compiled import Look, NativeBounds, NativeChain, NativeWorld
from planner.robot.clouds import Seen
from planner.robot.moving import KnownMotion
from planner.robot.shapes import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Mesh,
    Obstacle,
    Shape,
    Sphere,
    corners,
    max_distance_from_origin,
)

_NONE: Mapping[str, KnownMotion] = MappingProxyType({})
_SPHERES, _CELL = 6, 0.08  # spheres a body, and the cell size below which none is cut (m)
CONVEX = 1e-5  # m: a mesh nowhere deeper below its hull counts as convex
_BOXES = 64  # boxes a mesh obstacle


class ClearanceBound:
    """Lower bounds on pair distances in a world. Stateless once made; safe to share.

    bound = ClearanceBound(world)
    rotation, position = joint_placements(chain, q)          # n configurations
    bound.coarse(rotation, position)                         # (n, pairs)
    bound.close(rotation, position, rows, pairs)             # to a micrometre, for some of them
    """

    def __init__(
        self, world: World, known: ClearanceBound | None = None, motions: Mapping[str, KnownMotion] = _NONE
    ) -> None:
        """Build bounds for ``world``; shapes that ``known`` (same arm) has are shared with it.

        Obstacles named in ``motions`` follow these in proofs in time, and stand at their first pose elsewhere.
        """
        self.world = world
        self.native = NativeWorld(Chain.from_arm(world.robot).native, world.margin)
        old = {} if known is None else {item: k for k, item in enumerate(known.world.items)}
        arm = None if known else _arm(world.bodies, Chain.from_arm(world.robot).native)
        for k, body in enumerate(world.bodies):
            if arm is not None:
                self.native.take(arm, k)
            elif known is not None and body in old:
                self.native.take(known.native, old[body])
            else:
                _add_body(self.native, body)
        for item in world.obstacles:
            if known is not None and item in old and item.name not in motions:
                self.native.take(known.native, old[item])
            else:
                _add_obstacle(self.native, item, motions.get(item.name))
        bodies, obstacles = np.indices(world.checked.shape).reshape(2, -1)
        scene = np.stack([bodies, len(world.bodies) + obstacles], axis=1)
        checked = np.concatenate([world.checked.ravel(), np.ones(len(world.self_pairs), dtype=bool)])
        self.native.set_pairs(np.concatenate([scene, world.self_pairs]), checked)
        chain = Chain.from_arm(world.robot)
        if chain.prismatic.any():
            slides = [travel(world.robot.without_payload, chain, row) for row in range(len(chain.parent))]
            self.native.set_travel(np.where(chain.prismatic, slides, np.inf))

    def coarse(self, rotation: Floats, position: Floats) -> Floats:
        """Return lower bounds (n, pairs) in metres; +inf for pairs that are not checked.

        ``rotation`` (joints + 1, n, 3, 3) and ``position`` (joints + 1, n, 3) are from ``joint_placements``.
        """
        return self.native.coarse(rotation, position)

    def close(
        self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints, enough: Floats | float = np.inf
    ) -> Floats:
        """Return lower bounds (k,) in metres for pair ``pairs[k]`` in configuration ``rows[k]``; 0 in contact.

        They are within a micrometre of the distance, or at least ``enough`` (k,) m.
        """
        return self.native.close(rotation, position, rows, pairs, enough)

    def first_near(self, q: Floats) -> tuple[int, int] | None:
        """Return the first of (n, dof) configurations that is not proven clear of the margin, and its pair."""
        row = self.native.first_near(q)
        if row == len(q):
            return None
        rotation, position = joint_placements(Chain.from_arm(self.world.robot), q[row : row + 1])
        pairs = np.flatnonzero(self.coarse(rotation, position)[0] <= self.world.margin)
        gaps = self.close(rotation, position, np.zeros_like(pairs), pairs)
        return row, int(pairs[gaps.argmin()])

    def is_clear(self, q: Floats) -> bool:
        """Return whether all configurations (n, dof) are proven clear of the margin; enclosure is ignored."""
        return self.native.first_near(q) == len(q)

    def is_each_clear(self, q: Floats) -> Bools:
        """Return :meth:`is_clear` (n,) for each configuration."""
        free, row = np.ones(len(q), dtype=bool), 0
        while (row := row + self.native.first_near(q[row:])) < len(q):
            free[row] = False
            row += 1
        return free

    @cached_property
    def motion_bounds(self) -> NativeBounds:
        """Bounds on the speed of every pair and body per unit of joint speed."""
        world = self.world
        return self.native.bounds(world.pair_reach, world.reach.bodies, ~world.moving)

    def make_state_check(self, step: float) -> Look:
        """Return a contact check of straight motions by sampled states at most ``step`` (m) apart.

        It tests ends and middles first. One thread may use it at a time.
        """
        return self.native.look(self.motion_bounds, step)


@lru_cache(maxsize=8)
def _arm(bodies: tuple[Body, ...], chain: NativeChain) -> NativeWorld:
    """Return the bodies of an arm; worlds with different obstacles share them."""
    native = NativeWorld(chain, 0.0)
    for item in bodies:
        _add_body(native, item)
    return native


def _add_body(native: NativeWorld, item: Body) -> None:
    number, cover = _add(native, item.joint, item.shape, item.placement), _cover(item.shape)
    turn, shift = item.placement[:3, :3], item.placement[:3, 3]
    native.add_spheres(number, cover.centres @ turn.T + shift, cover.radii)


@lru_cache(maxsize=1024)
def _cover(shape: Shape) -> Spheres:
    if not isinstance(shape, Mesh):
        return sphere_cover(shape, _SPHERES, _CELL)
    arrays = load_or_compute(
        "spheres", [*shape.content(), _SPHERES, _CELL], lambda: vars(sphere_cover(shape, _SPHERES, _CELL))
    )
    return Spheres(frozen(arrays["centres"]), frozen(arrays["radii"]))


def _add_obstacle(native: NativeWorld, item: Obstacle, motion: KnownMotion | None) -> None:
    placed = item if motion is None else replace(item, placement=np.eye(4))  # in the frame that moves
    number = _add(native, -1, placed.shape, placed.placement)
    _add_targets(native, number, placed)
    native.set_speed_limit(number, item.speed_limit)
    if motion is not None:
        angles = np.linalg.norm(motion.turns, axis=1)
        axes = np.divide(motion.turns, angles[:, None], out=np.zeros_like(motion.turns), where=angles[:, None] > 0)
        turn, shift, rates = motion.poses[:, :3, :3], motion.poses[:, :3, 3], angles / np.diff(motion.times)
        size = max_distance_from_origin(item.shape, np.eye(4))
        native.set_motion(number, motion.times, turn, shift, axes, rates, motion.speeds(item.shape), size)


def _add(native: NativeWorld, joint: int, shape: Shape, placement: Floats) -> int:
    """Add a shape at a placement (4, 4) in a joint's frame (-1: the world); return its number."""
    turn, shift = placement[:3, :3], placement[:3, 3]
    if isinstance(shape, Cylinder):
        half = 0.5 * shape.length * turn[:, 2]
        return native.add_cylinder(joint, shift, half, shape.radius * turn[:, :2].T)
    if isinstance(shape, Mesh):
        if isinstance(shape, Seen):
            return native.add_cloud(joint, shape.cells @ turn.T + shift, shape.radius, _boxes_of(shape))
        points, depth = hull_of(shape)
        hull = points @ turn.T + shift
        if depth < CONVEX:
            return native.add_hull(joint, hull, shape.radius)
        triangles = (shape.vertices @ turn.T + shift)[shape.triangles]
        return native.add_surface(joint, hull, triangles, depth, shape.radius)
    points, radius = corners(shape)
    return native.add_hull(joint, points @ turn.T + shift, radius)


def _boxes_of(cloud: Seen) -> int:
    """Return how many boxes stand for a cloud: a box costs as much as a few of its cells."""
    return int(np.clip(len(cloud.cells) // 16, 1, _BOXES))


def _add_targets(native: NativeWorld, item: int, obstacle: Obstacle) -> None:
    turn, shift, shape = obstacle.placement[:3, :3], obstacle.placement[:3, 3], obstacle.shape
    if isinstance(shape, Seen):
        return  # the compiled cloud has made its own
    if isinstance(shape, Cylinder):
        half = np.array([shape.radius, 0.0, 0.5 * shape.length])
        native.add_target(item, turn, shift, half, 0.0, True)
        return
    centres, halves, radius = _enclosing_boxes(shape)
    for centre, half in zip(centres, halves, strict=True):
        native.add_target(item, turn, product(turn, centre) + shift, half, radius, False)


def _enclosing_boxes(shape: Shape) -> tuple[Floats, Floats, float]:
    """Return centres (k, 3), half sizes (k, 3) and the radius of rounded boxes that contain a shape."""
    match shape:
        case Sphere(radius):
            return np.zeros((1, 3)), np.zeros((1, 3)), radius
        case Capsule(radius, length):
            return np.zeros((1, 3)), np.array([[0.0, 0.0, 0.5 * length]]), radius
        case Mesh():
            return *box_cover(shape, _BOXES), shape.radius
        case Box(size):
            return np.zeros((1, 3)), 0.5 * np.array([size]), 0.0
    raise TypeError(f"no rounded box holds a {type(shape).__name__}")
