"""How far apart two convex shapes are for certain: any plane between them is a proof, however it was found."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from planner.base.arrays import Floats
from planner.base.products import dot, length, product
from planner.world.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere

Placed: TypeAlias = tuple[Shape, Floats, Floats]  # shape, rotation (3, 3), position (3,)

_ROUNDS = 40
_CLOSE = 2e-5  # m: a bound this near the distance is good enough


def proven_gap(first: Placed, second: Placed, apart: Floats) -> float:
    """A lower bound (m) on the distance of two convex shapes; ``apart`` (3,) leads from a point of the first to one
    of the second, ideally the nearest two. Negative where no plane was found between them.

    The planes across ``apart`` that just touch the shapes bound the distance from below, its length from above. While
    the two are far apart, ``apart`` is shortened as Gilbert (1966) does, towards the points that touch the planes.
    """
    best = -np.inf
    for _ in range(_ROUNDS):
        size = length(apart)
        if size <= 1e-12:
            break
        between = farthest_point(second, -apart) - farthest_point(first, apart)
        best = max(best, dot(between, apart) / size)
        step = between - apart
        stride = dot(step, step)
        if size - best < _CLOSE or stride <= 0.0:
            break
        apart = apart + min(1.0, max(0.0, -dot(apart, step) / stride)) * step
    return best


def plane_gap(first: Placed, second: Placed, apart: Floats) -> float:
    """The gap (m) between the two planes across ``apart`` that just touch the shapes; -inf for a zero ``apart``."""
    size = length(apart)
    if size <= 1e-12:
        return -np.inf
    return dot(farthest_point(second, -apart) - farthest_point(first, apart), apart) / size


def farthest_point(placed: Placed, direction: Floats) -> Floats:
    """The point (3,) of a placed shape that lies farthest along ``direction`` (3,), both in the world."""
    shape, turn, position = placed
    return position + turn @ _farthest_local(shape, product(direction, turn))


def _farthest_local(shape: Shape, direction: Floats) -> Floats:
    match shape:
        case Box(size):
            return 0.5 * np.copysign(size, direction)
        case Sphere(radius):
            return radius * direction / length(direction)
        case Capsule(radius, tall):
            tip = radius * direction / length(direction)
            tip[2] += np.copysign(0.5 * tall, direction[2])
            return tip
        case Cylinder(radius, tall):
            x, y, z = direction
            across = max(float(np.hypot(x, y)), 1e-300)
            return np.array([radius * x / across, radius * y / across, np.copysign(0.5 * tall, z)])
        case Mesh(vertices, _):
            return vertices[int(np.argmax(product(vertices, direction)))]
