"""Backend-neutral collision geometry: every checker and every clearance bound sees the same bodies.

Shapes are centred on their own frame as URDF has them: cylinders and capsules along z, lengths without caps. Sizes are
above 0, placements rigid, all of them finite: :class:`SceneError` for others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from planner.base.arrays import Floats, Ints, distinct_rows, frozen, indices, numbers, placement, product
from planner.base.errors import SceneError
from planner.base.yamlfile import FARTHEST, Size


class _Sized:
    """A shape that is made of its sizes: numbers above 0, in metres."""

    def __post_init__(self) -> None:
        for name, size in vars(self).items():
            what, shape = f"{type(self).__name__}.{name}", (3,) if name == "size" else ()
            found = numbers(what, size, shape, SceneError, FARTHEST)
            if not found.min() > 0:
                raise SceneError(f"{what} is {size}: give metres above 0.")
            object.__setattr__(self, name, tuple(found.tolist()) if shape else float(found))

    def content(self) -> list[Any]:
        """What a hash of the shape is taken over: its kind and its numbers."""
        return [type(self).__name__, *vars(self).values()]


@dataclass(frozen=True)
class Box(_Sized):
    """A box with full side lengths ``size`` (m)."""

    size: tuple[Size, Size, Size]


@dataclass(frozen=True)
class Sphere(_Sized):
    radius: Size


@dataclass(frozen=True)
class Cylinder(_Sized):
    """A cylinder along z, centred: ``length`` (m) from disc to disc."""

    radius: Size
    length: Size


@dataclass(frozen=True)
class Capsule(_Sized):
    """A capsule along z: ``length`` (m) between the centres of its two half spheres."""

    radius: Size
    length: Size


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle surface: ``vertices`` (n, 3) in metres, ``triangles`` (m, 3) vertex indices, at least one.

    With a ``radius`` (m) it stands for a surface of more triangles no point of which is farther than that from it
    (:func:`planner.robot.files.meshes.simplify`): what comes as near as that counts as a contact.
    """

    vertices: Floats
    triangles: Ints
    radius: float = 0.0

    def __post_init__(self) -> None:
        vertices = numbers("Mesh.vertices", self.vertices, ("n", 3), SceneError, FARTHEST)
        triangles = indices("Mesh.triangles", self.triangles, ("m", 3), len(vertices), SceneError)
        if not len(triangles):
            raise SceneError("a Mesh without triangles has no surface: give at least one.")
        object.__setattr__(self, "vertices", frozen(vertices))
        object.__setattr__(self, "triangles", frozen(triangles, np.int64))
        radius = float(numbers("Mesh.radius", self.radius, (), SceneError, FARTHEST))
        if not radius >= 0:
            raise SceneError(f"Mesh.radius is {radius:g}: give metres from 0 on.")
        object.__setattr__(self, "radius", radius)

    def content(self) -> list[Any]:
        """What a hash of the shape is taken over."""
        return [type(self).__name__, self.vertices, self.triangles, *([self.radius] if self.radius else [])]

    def merge_vertices(self) -> Mesh:
        """The same triangles with equal vertices as one, in the order in which triangles have them."""
        corners = self.vertices[self.triangles].reshape(-1, 3)
        first, which = distinct_rows(corners)
        order = np.argsort(first)
        rank = np.empty(len(order), dtype=np.int64)
        rank[order] = np.arange(len(order))
        return Mesh(corners[first[order]], rank[which].reshape(-1, 3), self.radius)


Shape: TypeAlias = Box | Sphere | Cylinder | Capsule | Mesh


def as_shape(what: str, given: Any) -> Shape:
    """A shape itself, or the mesh of a ``trimesh.Trimesh``, its numbers in metres; TypeError for anything else."""
    if isinstance(given, Shape):
        return given
    if hasattr(given, "vertices") and hasattr(given, "faces"):
        return Mesh(given.vertices, given.faces).merge_vertices()
    kinds = "planner.Box, Sphere, Cylinder, Capsule, Mesh or a trimesh.Trimesh"
    raise TypeError(f"{what}: shape must be a {kinds}, got {type(given).__name__}.")


@dataclass(frozen=True, eq=False)
class Body:
    """A shape that a robot joint carries (``joint`` 0 is the fixed base), placed in that joint's frame."""

    name: str
    link: str
    joint: int
    shape: Shape
    placement: Floats  # (4, 4), in the joint's frame
    color: tuple[float, float, float, float] = (0.7, 0.7, 0.7, 1.0)


class _Placed:
    """A shape with a name and a rigid placement; ``object_id`` names the object it is one of several shapes of."""

    name: str
    shape: Shape
    placement: Floats
    object_id: str | None
    speed_limit: float

    def __post_init__(self) -> None:
        what = f"{type(self).__name__.lower()} '{self.name}'"
        rigid = placement(f"{what}: placement", self.placement, SceneError, FARTHEST)
        object.__setattr__(self, "placement", frozen(rigid))
        object.__setattr__(self, "shape", as_shape(what, self.shape))
        if not numbers(f"{what}: speed_limit", self.speed_limit, (), SceneError, FARTHEST) >= 0:
            raise SceneError(f"{what}: speed_limit must be at least 0 m/s, got {self.speed_limit:g}.")

    @property
    def object(self) -> str:
        """The name under which permissions speak of it."""
        return self.object_id or self.name


@dataclass(frozen=True, eq=False)
class Obstacle(_Placed):
    """A shape, also a ``trimesh.Trimesh``, that stands still in the world at a placement, also a ``pinocchio.SE3``.

    With a ``speed_limit`` (m/s) it may leave its place at time 0, no point of it quicker than that: what is proven of
    such an obstacle holds for its place, and a trajectory's proof says until when whatever it does. ``frame`` is the
    frame of ``placement``, empty for the world; :func:`planner.robot.robot_in_scene.resolve_frames` resolves it.
    """

    name: str
    shape: Shape
    placement: Floats  # (4, 4), in the world
    object_id: str | None = None
    speed_limit: float = 0.0  # m/s
    frame: str = ""


@dataclass(frozen=True, eq=False)
class Carried(_Placed):
    """A shape that a link carries, placed (4, 4) in the link's frame, or in ``frame``, one that moves with the link.

    It may touch ``touch_links``. Put down it has its ``speed_limit`` (m/s) again; in the hold it goes along.
    """

    link: str
    name: str
    shape: Shape
    placement: Floats
    touch_links: tuple[str, ...] = ()
    frame: str = ""
    speed_limit: float = 0.0
    object_id: str | None = None


CORNERS = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T  # (8, 3) of a cube


def corners(shape: Shape) -> tuple[Floats, float]:
    """Points and a radius whose rounded convex hull contains the shape: ((k, 3), r)."""
    match shape:
        case Box(size):
            return CORNERS * np.asarray(size), 0.0
        case Sphere(radius):
            return np.zeros((1, 3)), radius
        case Capsule(radius, length):
            return np.array([[0, 0, -0.5 * length], [0, 0, 0.5 * length]]), radius
        case Cylinder(radius, length):
            # the circumscribed box of the discs: conservative by a factor sqrt(2) at four lines
            return CORNERS * np.array([2.0 * radius, 2.0 * radius, length]), 0.0
        case Mesh():
            return shape.vertices, shape.radius


def bounding_box(shape: Shape) -> tuple[Floats, Floats]:
    """The smallest and largest coordinates (3,) of a shape in its own frame."""
    points, radius = corners(shape)
    return points.min(axis=0) - radius, points.max(axis=0) + radius


def max_distance_from_origin(shape: Shape, placement: Floats) -> float:
    """The largest distance (m) of a point of the placed shape from the frame's origin, never too small."""
    if isinstance(shape, Cylinder):
        # the farthest point lies on one of the two rims; the rim's circle is bounded by its own radius
        local = product(-placement[:3, 3], placement[:3, :3])  # the origin, seen from the cylinder
        across = float(np.hypot(local[0], local[1])) + shape.radius
        along = max(abs(end - local[2]) for end in (-0.5 * shape.length, 0.5 * shape.length))
        return float(np.hypot(across, along))
    points, radius = corners(shape)
    world = points @ placement[:3, :3].T + placement[:3, 3]
    return float(np.linalg.norm(world, axis=1).max() + radius)


def max_distance_from_axis(shape: Shape, placement: Floats, axis: Floats) -> float:
    """The largest distance (m) of a point of the placed shape from the line through the origin along ``axis``."""
    points, radius = corners(shape)
    world = points @ placement[:3, :3].T + placement[:3, 3]
    across = world - np.outer(product(world, axis), axis)
    return min(float(np.linalg.norm(across, axis=1).max() + radius), max_distance_from_origin(shape, placement))
