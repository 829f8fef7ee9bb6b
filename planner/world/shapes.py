"""Backend-neutral collision geometry: every checker and every clearance bound sees the same bodies.

Shapes are centred on their own frame as URDF has them: cylinders and capsules along z, lengths without caps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from planner.base.arrays import Floats, Ints, frozen
from planner.base.products import product


class _Content:
    def content(self) -> list[Any]:
        """What a hash of the shape is taken over: its kind and its numbers."""
        return [type(self).__name__, *vars(self).values()]


@dataclass(frozen=True)
class Box(_Content):
    """A box with full side lengths ``size`` (m)."""

    size: tuple[float, float, float]


@dataclass(frozen=True)
class Sphere(_Content):
    radius: float


@dataclass(frozen=True)
class Cylinder(_Content):
    """A cylinder along z, centred: ``length`` (m) from disc to disc."""

    radius: float
    length: float


@dataclass(frozen=True)
class Capsule(_Content):
    """A capsule along z: ``length`` (m) between the centres of its two half spheres."""

    radius: float
    length: float


@dataclass(frozen=True, eq=False)
class Mesh(_Content):
    """A triangle surface: ``vertices`` (n, 3) in metres, ``triangles`` (m, 3) vertex indices."""

    vertices: Floats
    triangles: Ints

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", frozen(self.vertices))
        object.__setattr__(self, "triangles", frozen(self.triangles, np.int64))


Shape: TypeAlias = Box | Sphere | Cylinder | Capsule | Mesh


@dataclass(frozen=True, eq=False)
class Body:
    """A shape that a robot joint carries (``joint`` 0 is the fixed base), placed in that joint's frame."""

    name: str
    link: str
    joint: int
    shape: Shape
    placement: Floats  # (4, 4), in the joint's frame
    color: tuple[float, float, float, float] = (0.7, 0.7, 0.7, 1.0)


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A shape that stands still in the world; ``part_of`` names the object it is one of several shapes of.

    With a ``speed_limit`` (m/s) it may leave its place at time 0, no point of it quicker than that: what is proven of
    such an obstacle holds for its place, and a trajectory's proof says until when whatever it does. ``frame`` is that
    of the ``placement``, empty for the world; :func:`planner.world.frames.in_world` brings an obstacle there.
    """

    name: str
    shape: Shape
    placement: Floats  # (4, 4), in the world
    part_of: str | None = None
    speed_limit: float = 0.0  # m/s
    frame: str = ""

    @property
    def object(self) -> str:
        """The name under which permissions speak of it."""
        return self.part_of or self.name


@dataclass(frozen=True, eq=False)
class Carried:
    """A shape that a link carries, placed (4, 4) in the link's frame, or in ``frame``, one that moves with the link.

    It may touch ``touch_links``.
    """

    link: str
    name: str
    shape: Shape
    placement: Floats
    touch_links: tuple[str, ...] = ()
    frame: str = ""


def corners(shape: Shape) -> tuple[Floats, float]:
    """Points and a radius whose rounded convex hull contains the shape: ((k, 3), r)."""
    match shape:
        case Box(size):
            signs = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
            return signs * np.asarray(size), 0.0
        case Sphere(radius):
            return np.zeros((1, 3)), radius
        case Capsule(radius, length):
            return np.array([[0, 0, -0.5 * length], [0, 0, 0.5 * length]]), radius
        case Cylinder(radius, length):
            # the circumscribed box of the discs: conservative by a factor sqrt(2) at four lines
            signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-0.5, 0.5])).reshape(3, -1).T
            return signs * np.array([radius, radius, length]), 0.0
        case Mesh(vertices, _):
            return vertices, 0.0


def farthest(shape: Shape, placement: Floats) -> float:
    """The largest distance (m) of a point of the placed shape from the frame's origin, never too small."""
    if isinstance(shape, Cylinder):
        return _farthest_of_cylinder(shape, placement)
    points, radius = corners(shape)
    world = points @ placement[:3, :3].T + placement[:3, 3]
    return float(np.linalg.norm(world, axis=1).max() + radius)


def farthest_from_axis(shape: Shape, placement: Floats, axis: Floats) -> float:
    """The largest distance (m) of a point of the placed shape from the line through the origin along ``axis``."""
    points, radius = corners(shape)
    world = points @ placement[:3, :3].T + placement[:3, 3]
    across = world - np.outer(product(world, axis), axis)
    return min(float(np.linalg.norm(across, axis=1).max() + radius), farthest(shape, placement))


def _farthest_of_cylinder(shape: Cylinder, placement: Floats) -> float:
    # the farthest point lies on one of the two rims; the rim's circle is bounded by its own radius
    centres = np.array([[0, 0, -0.5 * shape.length], [0, 0, 0.5 * shape.length]])
    local = product(-placement[:3, 3], placement[:3, :3])  # the origin, seen from the cylinder
    across = float(np.hypot(local[0], local[1])) + shape.radius
    along = float(np.abs(centres[:, 2] - local[2]).max())
    return float(np.hypot(across, along))
