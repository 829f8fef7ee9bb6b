"""Lower bounds on the distance of every pair: cheap ones by spheres, close ones by planes between convex sets.

Each body is covered by spheres, each obstacle is a rounded box or a cylinder (a mesh: many boxes), and the distance of
a sphere from either is a formula. Where that says too little, two parallel planes between the shapes say how far apart
they are at least, to a micrometre; a mesh that is not convex counts as the surface of its triangles. Neither bound
exceeds the true distance, so what they clear needs no check by a collision library.
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
_CONVEX = 1e-5  # m: a mesh nowhere deeper below its hull counts as convex
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
        """``known``: the bounds of another world of the same arm; what is in both is taken from there, as it moves.

        ``motions``: of obstacles by name; elsewhere than in proofs in time they are where they begin.
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
        """(n, pairs) lower bounds in metres; +inf for pairs that are not checked.

        ``rotation`` (joints + 1, n, 3, 3) and ``position`` (joints + 1, n, 3) as ``joint_placements`` gives them.
        """
        return self.native.coarse(rotation, position)

    def close(
        self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints, enough: Floats | float = np.inf
    ) -> Floats:
        """(k,) lower bounds (m) for configuration ``rows[k]`` and pair ``pairs[k]``, to a micrometre; 0 in contact.

        Bounds of ``enough`` (k,) m need not be better.
        """
        return self.native.close(rotation, position, rows, pairs, enough)

    def first_near(self, q: Floats) -> tuple[int, int] | None:
        """The first configuration of (n, dof) in which a pair is not proven farther apart than the margin, and which.

        None where there is none.
        """
        row = self.native.first_near(q)
        if row == len(q):
            return None
        rotation, position = joint_placements(Chain.from_arm(self.world.robot), q[row : row + 1])
        pairs = np.flatnonzero(self.coarse(rotation, position)[0] <= self.world.margin)
        gaps = self.close(rotation, position, np.zeros_like(pairs), pairs)
        return row, int(pairs[gaps.argmin()])

    def is_clear(self, q: Floats) -> bool:
        """Whether no surfaces of checked pairs are within the margin in any configuration (n, dof)."""
        return self.native.first_near(q) == len(q)

    def is_each_clear(self, q: Floats) -> Bools:
        """The same (n,) of each configuration by itself."""
        free, row = np.ones(len(q), dtype=bool), 0
        while (row := row + self.native.first_near(q[row:])) < len(q):
            free[row] = False
            row += 1
        return free

    @cached_property
    def motion_bounds(self) -> NativeBounds:
        """How fast all pairs and bodies move at most, as proofs and looks ask."""
        world = self.world
        return self.native.bounds(world.pair_reach, world.reach.bodies, ~world.moving)

    def make_state_check(self, step: float) -> Look:
        """The same of states along straight motions from a start by a delta (dof,), their ends and middles first.

        Between two of them no point moves further than ``step`` (m). One thread asks it.
        """
        return self.native.look(self.motion_bounds, step)


@lru_cache(maxsize=8)
def _arm(bodies: tuple[Body, ...], chain: NativeChain) -> NativeWorld:
    """The bodies of an arm, from which worlds take theirs: made once, whatever obstacles there are."""
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
    """A shape placed (4, 4) in the frame of a joint, or of the world (-1); its number."""
    turn, shift = placement[:3, :3], placement[:3, 3]
    if isinstance(shape, Cylinder):
        half = 0.5 * shape.length * turn[:, 2]
        return native.add_cylinder(joint, shift, half, shape.radius * turn[:, :2].T)
    if isinstance(shape, Mesh):
        points, depth = hull_of(shape)
        hull = points @ turn.T + shift
        if depth < _CONVEX:
            return native.add_hull(joint, hull, shape.radius)
        if isinstance(shape, Seen):
            return native.add_surface(joint, hull, shape.cells @ turn.T + shift, depth, shape.radius)
        triangles = (shape.vertices @ turn.T + shift)[shape.triangles]
        return native.add_surface(joint, hull, triangles, depth, shape.radius)
    points, radius = corners(shape)
    return native.add_hull(joint, points @ turn.T + shift, radius)


def _add_targets(native: NativeWorld, item: int, obstacle: Obstacle) -> None:
    turn, shift, shape = obstacle.placement[:3, :3], obstacle.placement[:3, 3], obstacle.shape
    if isinstance(shape, Cylinder):
        half = np.array([shape.radius, 0.0, 0.5 * shape.length])
        native.add_target(item, turn, shift, half, 0.0, True)
        return
    centres, halves, radius = _rounded_boxes(shape)
    for centre, half in zip(centres, halves, strict=True):
        native.add_target(item, turn, product(turn, centre) + shift, half, radius, False)


def _rounded_boxes(shape: Shape) -> tuple[Floats, Floats, float]:
    """Centres (k, 3), half sizes (k, 3) and the rounding radius that contain a shape other than a cylinder."""
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
