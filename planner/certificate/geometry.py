"""The world as a certificate has it: joints, shapes and pairs as plain arrays, named as in verify_proof.FIELDS."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.certificate.verify_proof import ALLOWED, FORMAT, LISTED, MEETS, shapes
from planner.collision.hulls import hull_corners, hull_of
from planner.collision.world import World
from planner.kinematics.forward import Chain
from planner.models.shapes import Body, Cylinder, Mesh, Obstacle, corners

Arrays = dict[str, Any]
Cuts = Mapping[str, int]  # of bodies and obstacles whose hull is too much: into how many slabs each is cut
_WHOLE: Cuts = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Part:
    """A convex part of the world's item of a number: points (k, 3) in the frame of its joint, a radius around them."""

    item: int
    name: str
    points: Floats
    radius: float


def geometry_of(world: World, cuts: Cuts = _WHOLE) -> Arrays:
    """The arrays that say what stands where and what is checked."""
    parts = _parts(world, cuts)
    return _joints(world) | _items(world, parts) | _pairs(world, parts)


def words_of(world: World, cuts: Cuts = _WHOLE) -> dict[str, Any]:
    """What the certificate says in words: names, and the margin (m)."""
    robot, model = world.robot, world.robot.model
    own = np.array_equal(robot.lower, model.lowerPositionLimit) and np.array_equal(
        robot.upper, model.upperPositionLimit
    )
    return {
        "format": FORMAT,
        "robot": robot.name,
        "scene": world.scene.name,
        "joints": list(robot.joints),
        "items": [part.name for part in _parts(world, cuts)],
        "cuts": dict(cuts),
        "held": dict(robot.fixed_joints),
        "base": robot.base.tolist(),
        "widened": not own,
        "margin": float(world.margin),
        "identity": {"robot": robot.identity, "scene": world.scene.identity},
    }


def names_of(world: World) -> list[str]:
    """A name of its own for each body and obstacle."""
    names = [item.name for item in world.items]
    twice = {name for name in names if names.count(name) > 1}
    return [f"{name} ({k})" if name in twice else name for k, name in enumerate(names)]


def with_dents(world: World, names: set[str]) -> list[str]:
    """Those of the items of these names that are meshes with dents, so that slabs of them are less than their hull."""
    named = zip(names_of(world), world.items, strict=True)
    return [
        name for name, item in named if name in names and isinstance(item.shape, Mesh) and hull_of(item.shape)[1] > 0
    ]


def _parts(world: World, cuts: Cuts) -> list[Part]:
    made = []
    for k, (name, item) in enumerate(zip(names_of(world), world.items, strict=True)):
        hulls = [(name, *_points(item))]
        if name in cuts and isinstance(item.shape, Mesh):
            slabs = _slabs(item.shape, cuts[name])
            hulls = [(f"{name}, slab {n + 1}", points, item.shape.radius) for n, points in enumerate(slabs)]
        turn, shift = item.placement[:3, :3], item.placement[:3, 3]
        made += [Part(k, each, points @ turn.T + shift, float(radius)) for each, points, radius in hulls]
    return made


def _points(item: Body | Obstacle) -> tuple[Floats, float]:
    """Points (k, 3) in the frame of an item's shape, and the radius around them."""
    shape = item.shape
    if isinstance(shape, Cylinder):
        return np.array([[0, 0, -0.5 * shape.length], [0, 0, 0.5 * shape.length]]), shape.radius
    return (hull_of(shape)[0], shape.radius) if isinstance(shape, Mesh) else corners(shape)


@lru_cache(maxsize=256)
def _slabs(mesh: Mesh, count: int) -> list[Floats]:
    """Points (k, 3) of the mesh between planes across its longest side, ``count`` slabs, those without any left out.

    What a closed mesh holds between two parallel planes has its extreme points on the surface: the hulls of the slabs
    hold all of it.
    """
    corners_ = mesh.vertices[mesh.triangles]
    axis = int(np.ptp(corners_.reshape(-1, 3), axis=0).argmax())
    planes = np.linspace(corners_[..., axis].min(), corners_[..., axis].max(), count + 1)
    a, b = corners_.reshape(-1, 3), np.roll(corners_, -1, axis=1).reshape(-1, 3)
    cut = []
    for plane in planes:
        crossing = (a[:, axis] - plane) * (b[:, axis] - plane) < 0
        share = (plane - a[crossing, axis]) / (b[crossing, axis] - a[crossing, axis])
        cut.append(a[crossing] + share[:, None] * (b[crossing] - a[crossing]))
    made = []
    for k, (low, high) in enumerate(itertools.pairwise(planes)):
        inside = a[(a[:, axis] >= low) & (a[:, axis] <= high)]
        points = np.concatenate([inside, cut[k], cut[k + 1]])
        made += [hull_corners(points)] if len(points) else []
    return made


def _joints(world: World) -> Arrays:
    robot, chain = world.robot, Chain.of(world.robot)
    return {
        "parent": chain.parent,
        "prismatic": chain.prismatic.astype(np.uint8),
        "turn": chain.rotations[:, 0],
        "shift": chain.offset,
        "axis": chain.axis,
        "lower": robot.lower,
        "upper": robot.upper,
        "wraps": robot.continuous.astype(np.uint8),
    }


def _items(world: World, parts: list[Part]) -> Arrays:
    items = [world.items[part.item] for part in parts]
    return {
        "joint": np.array([item.joint if isinstance(item, Body) else -1 for item in items], dtype=np.int64),
        "cylinder": np.array([isinstance(item.shape, Cylinder) for item in items], dtype=np.uint8),
        "radius": np.array([part.radius for part in parts]),
        "count": np.array([len(part.points) for part in parts], dtype=np.int64),
        "points": np.concatenate([part.points for part in parts]),
    }


def _pairs(world: World, parts: list[Part]) -> Arrays:
    """Which pairs of parts are to be proven apart, as they are checked and a joint moves them; why others are not."""
    count = len(world.bodies)
    listed = np.zeros((len(world.items), len(world.items)), dtype=bool)
    listed[:count, count:] = world.checked
    listed[world.self_pairs[:, 0], world.self_pairs[:, 1]] = True
    item: Ints = np.array([part.item for part in parts], dtype=np.int64)
    joint = np.array([body.joint for body in world.bodies] + [0] * len(world.obstacles))[item]
    first, second = np.argwhere(np.triu((item < count)[:, None] | (item < count)[None, :], 1)).T
    rigid = joint[first] == joint[second]
    proven = (listed | listed.T)[item[first], item[second]] & ~rigid
    other = np.where(item[second] < count, LISTED, ALLOWED)
    pairs = np.column_stack([first, second])
    reason = np.where(rigid, MEETS, other).astype(np.uint8)
    return {"pairs": pairs[proven], "exempt": pairs[~proven], "reason": reason[~proven]}


def middles_of(arrays: Arrays) -> Floats:
    """A point (items, 3) in the middle of each item, in the frame of what carries it."""
    return np.array([0.5 * (points.min(axis=0) + points.max(axis=0)) for points, _ in shapes(arrays)])
