"""The world as a certificate has it: joints, shapes and pairs as plain arrays, named as in verify_proof.FIELDS."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from planner.base.arrays import Floats, so_far
from planner.certificate.verify_proof import ALLOWED, FORMAT, LISTED, MEETS
from planner.collision.hulls import hull_of
from planner.collision.world import World
from planner.kinematics.forward import Chain
from planner.models.shapes import Body, Cylinder, Mesh, Obstacle, corners

Arrays = dict[str, Any]


def geometry_of(world: World) -> Arrays:
    """The arrays that say what stands where and what is checked; the rows of ``pairs`` are those of :func:`numbers`."""
    return _joints(world) | _items(world) | _pairs(world)


def words_of(world: World) -> dict[str, Any]:
    """What the certificate says in words: names, and the margin (m)."""
    robot, items = world.robot, world.items
    names = [item.name for item in items]
    twice = {name for name in names if names.count(name) > 1}
    named = [f"{name} ({k})" if name in twice else name for k, name in enumerate(names)]
    return {
        "format": FORMAT,
        "robot": robot.name,
        "scene": world.scene.name,
        "joints": list(robot.joints),
        "items": named,
        "bodies": [item.name for item in world.bodies],
        "links": [item.link for item in world.bodies],
        "held": dict(robot.fixed_joints),
        "base": robot.base.tolist(),
        "widened": not (
            np.array_equal(robot.lower, robot.model.lowerPositionLimit)
            and np.array_equal(robot.upper, robot.model.upperPositionLimit)
        ),
        "margin": float(world.margin),
        "identity": {"robot": robot.identity, "scene": world.scene.identity},
    }


def numbers(world: World) -> Any:
    """The numbers (p,) of the pairs that are to be proven apart: those that are checked and that a joint moves."""
    checked = np.concatenate([world.checked.ravel(), np.ones(len(world.self_pairs), dtype=bool)])
    return np.flatnonzero(checked & world.moving)


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


def _items(world: World) -> Arrays:
    made = [_points(item) for item in world.items]
    return {
        "joint": np.array([item.joint if isinstance(item, Body) else -1 for item in world.items], dtype=np.int64),
        "cylinder": np.array([isinstance(item.shape, Cylinder) for item in world.items], dtype=np.uint8),
        "radius": np.array([radius for _, radius in made]),
        "count": np.array([len(points) for points, _ in made], dtype=np.int64),
        "points": np.concatenate([points for points, _ in made]),
    }


def _points(item: Body | Obstacle) -> tuple[Floats, float]:
    """Points (k, 3) in the frame of what carries an item, and the radius around them."""
    shape = item.shape
    if isinstance(shape, Cylinder):
        points, radius = np.array([[0, 0, -0.5 * shape.length], [0, 0, 0.5 * shape.length]]), shape.radius
    elif isinstance(shape, Mesh):
        points, radius = hull_of(shape)[0], shape.radius
    else:
        points, radius = corners(shape)
    return points @ item.placement[:3, :3].T + item.placement[:3, 3], float(radius)


def _pairs(world: World) -> Arrays:
    """Which pairs of items are proven apart, and why the others are not."""
    count, proven = len(world.bodies), numbers(world)
    members = np.array([world.members(int(pair)) for pair in proven], dtype=np.int64).reshape(-1, 2)
    members[:, 1] += count * (proven < world.checked.size)
    listed = np.zeros((len(world.items), len(world.items)), dtype=bool)
    listed[members[:, 0], members[:, 1]] = True
    bodies = np.arange(len(world.items)) < count
    exempt = np.argwhere(np.triu((bodies[:, None] | bodies[None, :]) & ~(listed | listed.T), 1))
    joint = np.array([item.joint for item in world.bodies] + [0] * len(world.obstacles))
    rigid = joint[exempt[:, 0]] == joint[exempt[:, 1]]
    other = np.where(exempt[:, 1] < count, LISTED, ALLOWED)
    return {"pairs": members, "exempt": exempt, "reason": np.where(rigid, MEETS, other).astype(np.uint8)}


def enclosing_spheres(arrays: Arrays) -> tuple[Floats, Floats]:
    """Middles (items, 3), in the frame of what carries an item, and radii (items,) of spheres that hold the items."""
    ends = so_far(arrays["count"])
    parts = [arrays["points"][a:b] for a, b in itertools.pairwise(ends)]
    middles = np.array([0.5 * (part.min(axis=0) + part.max(axis=0)) for part in parts])
    far = [np.linalg.norm(part - middle, axis=1).max() for part, middle in zip(parts, middles, strict=True)]
    return middles, np.array(far) + arrays["radius"]
