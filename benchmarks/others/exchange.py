"""A planning problem as plain data, for a process that knows nothing of this package."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import numpy as np

from planner.base.errors import PlannerError
from planner.query.query import Query
from planner.robot.robot import Robot
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Obstacle, Sphere


def describe_problem(query: Query, seed: int, seconds: float) -> dict[str, Any]:
    """URDF, held joints, link pairs that need no check, obstacles, start and first goal, as JSON can hold them.

    Obstacles carry ``placement``, a matrix (4, 4). Raises :class:`PlannerError` for content that the other
    planners do not accept: meshes and capsules among the obstacles, carried shapes, a base outside the origin.
    """
    robot = query.robot
    if robot.carried or not np.allclose(robot.base, np.eye(4), atol=0.0):
        raise PlannerError("carried shapes and a base of one's own are left out of this comparison.")
    return {
        "urdf": _within_limits(robot),
        "package_dirs": robot.source.package_dirs,
        "joints": list(robot.joints),
        "held": {name: float(value) for name, value in robot.fixed_joints.items()},
        "free_pairs": sorted(sorted(pair) for pair in _unchecked_pairs(query)),
        "obstacles": [{"name": item.name, **_shape(item)} for item in query.scene.obstacles],
        "start": query.starts[0].tolist(),
        "goal": query.goals[0].tolist(),
        "seed": seed,
        "seconds": seconds,
    }


def _within_limits(robot: Robot) -> str:
    """The URDF with the limits that this robot has, which may be wider, and none that its held joints exceed."""
    tree = ET.fromstring(robot.source.xml)
    limits = {name: (low, high) for name, low, high in zip(robot.joints, robot.lower, robot.upper, strict=True)}
    for joint in tree.iter("joint"):
        name, limit = joint.get("name", ""), joint.find("limit")
        if limit is None:
            continue
        low, high = (float(limit.get(end, "0")) for end in ("lower", "upper"))
        value = robot.fixed_joints.get(name, low)
        low, high = limits.get(name, (min(low, value), max(high, value)))
        limit.set("lower", repr(float(low)))
        limit.set("upper", repr(float(high)))
    return ET.tostring(tree, encoding="unicode")


def _unchecked_pairs(query: Query) -> set[frozenset[str]]:
    """Pairs of links none of whose shapes are checked against each other."""
    world = query.checker.world
    names = {body.link for body in world.bodies}
    every = {frozenset((a, b)) for a in names for b in names if a != b}
    checked = {frozenset((world.bodies[i].link, world.bodies[k].link)) for i, k in world.self_pairs}
    return every - checked


def _shape(obstacle: Obstacle) -> dict[str, Any]:
    placement = {"placement": obstacle.placement.tolist()}
    match obstacle.shape:
        case Box(size):
            return {"type": "box", "size": list(size), **placement}
        case Sphere(radius):
            return {"type": "sphere", "radius": radius, **placement}
        case Cylinder(radius, length):
            return {"type": "cylinder", "radius": radius, "length": length, **placement}
        case Capsule() | Mesh():
            raise PlannerError(f"obstacle '{obstacle.name}' is a capsule or a mesh: left out of this comparison.")
