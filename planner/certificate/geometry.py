"""The arrays of a certificate for a world: joints, shapes and pairs, named as verify_proof.FIELDS."""

import itertools
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import StateError
from planner.certificate.verify_proof import EXEMPT, FORMAT, PROVEN, TERMS, Shape
from planner.collision.bounding_volumes import hull_corners, hull_of, split_pieces
from planner.collision.world import World
from planner.kinematics.forward import Chain, tool_joint
from planner.problem.targets import HOME, follow_names, joints_text
from planner.robot.clouds import Points, Seen
from planner.robot.shapes import Body, Cylinder, Mesh, Obstacle, corners

Arrays = dict[str, Any]
Cuts = Mapping[str, int]  # numbers of slabs of the bodies and obstacles whose hull is too large
_UNCUT: Cuts = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class ConvexShape:
    """A convex shape of an item of the world: points (k, 3) in its joint's frame, with a radius."""

    item: int
    name: str
    points: Floats
    radius: float


def extract_geometry(world: World, cuts: Cuts = _UNCUT) -> Arrays:
    """Return the arrays of joints, items and pairs."""
    shapes = _convex_shapes(world, cuts)
    items = _items(world, shapes)
    left = _pair_states(world, shapes, moving_pairs(items["joint"]))
    return _joints(world) | items | {"left": left, "margin": world.margin}


def describe_world(world: World, cuts: Cuts = _UNCUT) -> dict[str, Any]:
    """Return the words of the certificate."""
    robot, model, rows = world.robot, world.robot.model, world.robot.rows
    own = np.array_equal(robot.lower, model.lowerPositionLimit[rows]) and np.array_equal(
        robot.upper, model.upperPositionLimit[rows]
    )
    return {
        "format": FORMAT,
        "robot": robot.name,
        "scene": world.scene.name,
        "joints": list(robot.joints),
        "tree": list(model.names)[1:],
        "items": [shape.name for shape in _convex_shapes(world, cuts)],
        "cuts": dict(cuts),
        "clouds": {
            name: {key: getattr(item.shape, key) for key in TERMS} | {"estimated": item.shape.is_estimated}
            for name, item in zip(unique_names(world), world.items, strict=True)
            if isinstance(item.shape, Points)
        },
        "held": dict(robot.fixed_joints),
        "widened": not own,
        "rows": robot.jacobian_rows,
        "tool link": robot.tool,
        "states": _states(world),
        "identity": {"robot": robot.identity, "scene": world.scene.identity},
    }


def _states(world: World) -> dict[str, list[str]]:
    """Return the texts of each named state of the robot in the scene."""
    robot = world.robot
    named = {name: joints_text(values) for name, values in robot.states.items()} | {HOME: joints_text(robot.home)}
    named |= world.scene.states_of(robot.name)
    texts = {}
    for name in named:
        with suppress(StateError):  # a circular name, which no plan uses
            texts[name] = follow_names(name, named)
    return texts


def unique_names(world: World) -> list[str]:
    """Return a unique name for each body and obstacle."""
    names = [item.name for item in world.items]
    twice = {name for name in names if names.count(name) > 1}
    return [f"{name} ({k})" if name in twice else name for k, name in enumerate(names)]


def find_concave(world: World, names: set[str]) -> list[str]:
    """Return the items with these names that are concave meshes, whose slabs are less than their hull."""
    named = zip(unique_names(world), world.items, strict=True)
    return [
        name for name, item in named if name in names and isinstance(item.shape, Mesh) and hull_of(item.shape)[1] > 0
    ]


def _convex_shapes(world: World, cuts: Cuts) -> list[ConvexShape]:
    shapes = []
    for k, (name, item) in enumerate(zip(unique_names(world), world.items, strict=True)):
        hulls = [(name, *_points(item))]
        if name in cuts and isinstance(item.shape, Mesh):
            slabs = _slabs(item.shape, cuts[name])
            hulls = [(f"{name}, slab {n + 1}", points, item.shape.radius) for n, points in enumerate(slabs)]
        turn, shift = item.placement[:3, :3], item.placement[:3, 3]
        shapes += [ConvexShape(k, each, points @ turn.T + shift, float(radius)) for each, points, radius in hulls]
    return shapes


def _points(item: Body | Obstacle) -> tuple[Floats, float]:
    """Return points (k, 3) in the frame of an item's shape, and the radius around them."""
    shape = item.shape
    if isinstance(shape, Cylinder):
        return np.array([[0, 0, -0.5 * shape.length], [0, 0, 0.5 * shape.length]]), shape.radius
    return (hull_of(shape)[0], shape.radius) if isinstance(shape, Mesh) else corners(shape)


@lru_cache(maxsize=256)
def _slabs(mesh: Mesh, count: int) -> list[Floats]:
    """Return points (k, 3) of ``count`` slabs of the mesh across its longest side, without empty slabs.

    Of what a sensor saw, groups of its cells take their place.
    The extreme points of a closed mesh between two parallel planes are on the surface: the hulls of the slabs contain
    it.
    """
    if isinstance(mesh, Seen):
        return [hull_corners(mesh.cells[group].reshape(-1, 3)) for group in split_pieces(mesh, count)]
    corners_ = mesh.vertices[mesh.triangles]
    axis = int(np.ptp(corners_.reshape(-1, 3), axis=0).argmax())
    planes = np.linspace(corners_[..., axis].min(), corners_[..., axis].max(), count + 1)
    a, b = corners_.reshape(-1, 3), np.roll(corners_, -1, axis=1).reshape(-1, 3)
    cut = []
    for plane in planes:
        crossing = (a[:, axis] - plane) * (b[:, axis] - plane) < 0
        share = (plane - a[crossing, axis]) / (b[crossing, axis] - a[crossing, axis])
        cut.append(a[crossing] + share[:, None] * (b[crossing] - a[crossing]))
    slabs = []
    for k, (low, high) in enumerate(itertools.pairwise(planes)):
        inside = a[(a[:, axis] >= low) & (a[:, axis] <= high)]
        points = np.concatenate([inside, cut[k], cut[k + 1]])
        slabs += [hull_corners(points)] if len(points) else []
    return slabs


def _joints(world: World) -> Arrays:
    robot, chain = world.robot, Chain.from_arm(world.robot)
    carrier, tool = tool_joint(robot)
    return {
        "parent": chain.parent,
        "prismatic": chain.prismatic.astype(np.uint8),
        "turn": chain.rotations[:, 0],
        "shift": chain.offset,
        "axis": chain.axis,
        "leader": chain.leader,
        "factor": chain.factor,
        "zero": chain.zero,
        "lower": robot.lower,
        "upper": robot.upper,
        "wraps": robot.continuous.astype(np.uint8),
        "base": robot.base,
        "tool": tool.homogeneous,
        "carrier": carrier,
    }


def _items(world: World, shapes: list[ConvexShape]) -> Arrays:
    items = [world.items[shape.item] for shape in shapes]
    return {
        "joint": np.array([item.joint if isinstance(item, Body) else -1 for item in items], dtype=np.int64),
        "cylinder": np.array([isinstance(item.shape, Cylinder) for item in items], dtype=np.uint8),
        "radius": np.array([shape.radius for shape in shapes]),
        "count": np.array([len(shape.points) for shape in shapes], dtype=np.int64),
        "points": np.concatenate([shape.points for shape in shapes]),
    }


def moving_pairs(joint: Ints) -> Ints:
    """Return the pairs (k, 2), in order, of items on joints (n,) that some joint moves.

    Joint 0 is the base, -1 the world.
    """
    moved = (joint[:, None] != joint) & (np.maximum(joint[:, None], joint) > 0)
    return np.argwhere(np.triu(moved))


def _pair_states(world: World, shapes: list[ConvexShape], pairs: Ints) -> Ints:
    """Return for each of ``pairs`` (k, 2) of shapes whether it is to be proven apart or left out."""
    count = len(world.bodies)
    listed = np.zeros((len(world.items), len(world.items)), dtype=bool)
    listed[:count, count:] = world.checked
    listed[world.self_pairs[:, 0], world.self_pairs[:, 1]] = True
    first, second = np.array([shape.item for shape in shapes])[pairs].T
    return np.where((listed | listed.T)[first, second], PROVEN, EXEMPT)


def split_shapes(arrays: Arrays) -> list[Shape]:
    """Return the shape of each item in the frame of its joint, as the checker has it."""
    points = np.split(arrays["points"], np.cumsum(arrays["count"])[:-1])
    return list(zip(points, arrays["radius"].tolist(), arrays["cylinder"].tolist(), strict=True))


def box_centers(shapes: list[Shape]) -> Floats:
    """Return the center (items, 3) of each shape's box."""
    return np.array([0.5 * (points.min(axis=0) + points.max(axis=0)) for points, *_ in shapes])
