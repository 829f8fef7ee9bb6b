"""Cheap lower bounds on the distance of every pair, for many configurations at once.

Each body is covered by spheres, each obstacle is a rounded box or a cylinder (a mesh: many boxes), and the distance of
a sphere from either is a formula. A bound is never larger than the true distance, so what it clears needs no
exact check, and most of an edge is far from everything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.products import product
from planner.collision.covers import Spheres, box_cover, sphere_cover
from planner.collision.world import World
from planner.world.shapes import Body, Box, Capsule, Cylinder, Mesh, Obstacle, Shape, Sphere

# spheres a body in the first and in the second check, and the cell size below which none is cut (m)
_COARSE, _COARSE_CELL = 6, 0.08
_FINE, _FINE_CELL = 48, 0.02
_BOXES = 64  # boxes a mesh obstacle
_CHUNK = 100_000  # sphere-obstacle distances at a time: larger arrays leave the cache


@dataclass(frozen=True, eq=False)
class _Boxes:
    """All rounded boxes at once; box k belongs to the obstacle whose run of boxes starts at or before k."""

    rotations: Floats  # (3 k, 3): world to box, stacked
    offsets: Floats  # (3 k, 1)
    halves: Floats  # (k, 3, 1)
    radii: Floats  # (k, 1)

    def distance(self, points: Floats) -> Floats:
        """(k, m) distances of world ``points`` (3, m) from each box, minus its rounding radius."""
        beyond = self.rotations @ points
        beyond += self.offsets
        np.abs(beyond, out=beyond)
        beyond = beyond.reshape(len(self.halves), 3, -1)
        beyond -= self.halves
        np.maximum(beyond, 0.0, out=beyond)
        return _length(beyond) - self.radii


@dataclass(frozen=True, eq=False)
class _Cylinders:
    rotations: Floats  # (3 k, 3)
    offsets: Floats  # (3 k, 1)
    radii: Floats  # (k, 1)
    halves: Floats  # (k, 1)

    def distance(self, points: Floats) -> Floats:
        local = self.rotations @ points
        local += self.offsets
        local = local.reshape(len(self.radii), 3, -1)
        along = np.abs(local[:, 2]) - self.halves
        np.maximum(along, 0.0, out=along)
        np.square(local, out=local)
        across = np.sqrt(local[:, 0] + local[:, 1])  # np.hypot takes five times as long
        across -= self.radii
        np.maximum(across, 0.0, out=across)
        np.square(across, out=across)
        across += np.square(along, out=along)
        return np.sqrt(across, out=across)


def _length(vectors: Floats) -> Floats:
    """Norms over axis 1 of (k, 3, m), overwriting the input."""
    np.square(vectors, out=vectors)
    total = vectors[:, 0] + vectors[:, 1]
    total += vectors[:, 2]
    return np.sqrt(total, out=total)


def _frames(obstacles: list[Obstacle]) -> tuple[Floats, Floats]:
    rotations = [o.placement[:3, :3].T for o in obstacles]
    offsets = [product(-o.placement[:3, 3], o.placement[:3, :3]) for o in obstacles]
    return np.concatenate([np.zeros((0, 3)), *rotations]), np.concatenate([np.zeros(0), *offsets])[:, None]


class _Targets:
    """The obstacles that the spheres are measured against, and the rows of distances that belong to each."""

    def __init__(self, obstacles: tuple[Obstacle, ...]) -> None:
        self._round = [k for k, o in enumerate(obstacles) if isinstance(o.shape, Cylinder)]
        self._boxed = [k for k, o in enumerate(obstacles) if not isinstance(o.shape, Cylinder)]
        self._count = len(obstacles)
        cylinders = [obstacles[k] for k in self._round]
        shapes = [c.shape for c in cylinders if isinstance(c.shape, Cylinder)]
        self._cylinders = _Cylinders(
            *_frames(cylinders),
            radii=np.array([[shape.radius] for shape in shapes]).reshape(-1, 1),
            halves=np.array([[0.5 * shape.length] for shape in shapes]).reshape(-1, 1),
        )
        parts = [_rounded_boxes(obstacles[k].shape) for k in self._boxed]
        counts = [len(centres) for centres, _, _ in parts]
        self._first = np.cumsum([0, *counts[:-1]]) if counts else np.zeros(0, dtype=np.int64)
        rotations, offsets = _frames([obstacles[k] for k, n in zip(self._boxed, counts, strict=True) for _ in range(n)])
        centres = np.concatenate([np.zeros((0, 3)), *(part[0] for part in parts)])
        self._boxes = _Boxes(
            rotations,
            offsets - centres.reshape(-1, 1),
            np.concatenate([np.zeros((0, 3)), *(part[1] for part in parts)])[:, :, None],
            np.concatenate([np.zeros(0), *(np.full(n, part[2]) for n, part in zip(counts, parts, strict=True))])[
                :, None
            ],
        )

    def distance(self, points: Floats) -> Floats:
        """(obstacles, m) lower bounds for world ``points`` (3, m)."""
        result = np.empty((self._count, points.shape[1]))
        if self._boxed:
            gaps = self._boxes.distance(points)
            many = len(gaps) > len(self._boxed)
            result[self._boxed] = np.minimum.reduceat(gaps, self._first, axis=0) if many else gaps
        if self._round:
            result[self._round] = self._cylinders.distance(points)
        return result


def _rounded_boxes(shape: Shape) -> tuple[Floats, Floats, float]:
    """Centres (k, 3), half sizes (k, 3) and the rounding radius that contain a shape other than a cylinder."""
    match shape:
        case Sphere(radius):
            return np.zeros((1, 3)), np.zeros((1, 3)), radius
        case Capsule(radius, length):
            return np.zeros((1, 3)), np.array([[0.0, 0.0, 0.5 * length]]), radius
        case Mesh():
            return *box_cover(shape, _BOXES), 0.0
        case Box(size):
            return np.zeros((1, 3)), 0.5 * np.array([size]), 0.0
    raise TypeError(f"no rounded box holds a {type(shape).__name__}")


class ClearanceBound:
    """Lower bounds on pair distances in a world. Stateless once made; safe to share.

    bound = ClearanceBound(world)
    rotation, position = joint_placements(chain, q)          # n configurations
    bound.coarse(rotation, position)                         # (n, pairs)
    bound.refine(rotation, position, rows, pairs)            # closer, for some of them
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self._targets = _Targets(world.obstacles)
        self._single = [_Targets((obstacle,)) for obstacle in world.obstacles]
        self._coarse = [_placed(body, _COARSE, _COARSE_CELL) for body in world.bodies]
        self._fine = [_placed(body, _FINE, _FINE_CELL) for body in world.bodies]
        sizes = [len(cover.radii) for cover in self._coarse]
        self._radii = np.concatenate([np.zeros(0), *(cover.radii for cover in self._coarse)])
        self._first = np.cumsum([0, *sizes[:-1]]) if sizes else np.zeros(0, dtype=np.int64)
        self._self_first, self._self_a, self._self_b = self._sphere_pairs(sizes)
        self._ignored = np.concatenate([~world.checked.ravel(), np.zeros(len(world.self_pairs), dtype=bool)])

    def _sphere_pairs(self, sizes: list[int]) -> tuple[Ints, Ints, Ints]:
        """Every sphere of one body against every sphere of the other, pair after pair."""
        first, a, b = [], [], []
        count = 0
        for i, k in self.world.self_pairs:
            grid = np.meshgrid(np.arange(sizes[i]), np.arange(sizes[k]), indexing="ij")
            a.append(self._first[i] + grid[0].ravel())
            b.append(self._first[k] + grid[1].ravel())
            first.append(count)
            count += sizes[i] * sizes[k]
        empty = np.zeros(0, dtype=np.int64)
        return np.array(first, dtype=np.int64), np.concatenate([empty, *a]), np.concatenate([empty, *b])

    def coarse(self, rotation: Floats, position: Floats) -> Floats:
        """(n, pairs) lower bounds in metres; +inf for pairs that are not checked.

        ``rotation`` (joints + 1, n, 3, 3) and ``position`` (joints + 1, n, 3) as ``joint_placements`` gives them.
        """
        n = position.shape[1]
        if not len(self._radii):
            return np.full((n, len(self._ignored)), np.inf)
        width = max(1, len(self._radii) * max(len(self._single), 1) + len(self._self_a))
        step = max(1, _CHUNK // width)
        parts = [self._coarse_chunk(rotation[:, k : k + step], position[:, k : k + step]) for k in range(0, n, step)]
        return np.concatenate(parts) if parts else np.zeros((0, len(self._ignored)))

    def _coarse_chunk(self, rotation: Floats, position: Floats) -> Floats:
        n = position.shape[1]
        spheres = len(self._radii)
        centres = np.empty((3, spheres, n))
        for body, cover, first in zip(self.world.bodies, self._coarse, self._first, strict=True):
            centres[:, first : first + len(cover.radii)] = _place(cover, body, rotation, position)
        gaps = self._targets.distance(centres.reshape(3, -1)).reshape(-1, spheres, n)
        gaps -= self._radii[:, None]
        scene = np.minimum.reduceat(gaps, self._first, axis=1)  # (obstacles, bodies, n)
        scene = scene.transpose(2, 1, 0).reshape(n, -1)
        result = np.concatenate([scene, self._coarse_self(centres)], axis=1)
        result[:, self._ignored] = np.inf
        return result

    def _coarse_self(self, centres: Floats) -> Floats:
        if not len(self._self_first):
            return np.zeros((centres.shape[2], 0))
        apart = centres[:, self._self_a] - centres[:, self._self_b]
        gaps = _length(apart.transpose(1, 0, 2))
        gaps -= (self._radii[self._self_a] + self._radii[self._self_b])[:, None]
        return np.minimum.reduceat(gaps, self._self_first, axis=0).T

    def refine(self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints) -> Floats:
        """(k,) closer lower bounds for configuration ``rows[k]`` and pair ``pairs[k]``."""
        result = np.empty(len(rows))
        for pair in np.unique(pairs):
            which = np.nonzero(pairs == pair)[0]
            result[which] = self._refine_pair(int(pair), rotation[:, rows[which]], position[:, rows[which]])
        return result

    def _refine_pair(self, pair: int, rotation: Floats, position: Floats) -> Floats:
        first, second = self.world.members(pair)
        n = position.shape[1]
        cover = self._fine[first]
        centres = _place(cover, self.world.bodies[first], rotation, position)
        if self.world.is_scene_pair(pair):
            gaps = self._single[second].distance(centres.reshape(3, -1)).reshape(-1, n)
            return (gaps - cover.radii[:, None]).min(axis=0)
        other = self._fine[second]
        others = _place(other, self.world.bodies[second], rotation, position)
        gaps = np.linalg.norm(centres[:, :, None] - others[:, None], axis=0)
        gaps -= (cover.radii[:, None] + other.radii)[:, :, None]
        return gaps.min(axis=(0, 1))

    def can_refine(self, pair: int) -> bool:
        """Whether the second check has more spheres than the first: not for capsules."""
        members = self.world.members(pair)[: 1 if self.world.is_scene_pair(pair) else 2]
        return any(len(self._fine[m].radii) > len(self._coarse[m].radii) for m in members)


def _placed(body: Body, count: int, cell: float) -> Spheres:
    cover = sphere_cover(body.shape, count, cell)
    return Spheres(cover.centres @ body.placement[:3, :3].T + body.placement[:3, 3], cover.radii)


def _place(cover: Spheres, body: Body, rotation: Floats, position: Floats) -> Floats:
    """World centres (3, k, n) of a body's spheres."""
    turned = rotation[body.joint].reshape(-1, 3) @ cover.centres.T  # (3 n, k)
    centres = turned.reshape(-1, 3, len(cover.radii)).transpose(1, 2, 0)
    return centres + position[body.joint].T[:, None]
