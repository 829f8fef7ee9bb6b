"""Backend-neutral shapes: checkers and clearance bounds share the same bodies.

Shapes are centred in their frames as in URDF: cylinders and capsules along z, lengths without caps. Sizes are positive
and placements rigid; :class:`SceneError` otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from planner.base.arrays import Floats, Ints, column_bounds, distinct_rows, frozen, indices, numbers, placement, product
from planner.base.errors import SceneError
from planner.base.yamlfile import FARTHEST, Size


class _SizedShape:
    """A shape defined by positive sizes in metres."""

    def __post_init__(self) -> None:
        for name, size in vars(self).items():
            what, shape = f"{type(self).__name__}.{name}", (3,) if name == "size" else ()
            size_or_sizes = numbers(what, size, shape, SceneError, FARTHEST)
            if not size_or_sizes.min() > 0:
                raise SceneError(f"{what} must be above 0 m, got {size}: give it in metres.")
            object.__setattr__(self, name, tuple(size_or_sizes.tolist()) if shape else float(size_or_sizes))

    def content(self) -> list[Any]:
        """Return the values that a hash of the shape covers."""
        return [type(self).__name__, *vars(self).values()]


@dataclass(frozen=True)
class Box(_SizedShape):
    """A box with full side lengths ``size`` (m)."""

    size: tuple[Size, Size, Size]


@dataclass(frozen=True)
class Sphere(_SizedShape):
    radius: Size


@dataclass(frozen=True)
class Cylinder(_SizedShape):
    """A cylinder along z, centred: ``length`` (m) from disc to disc."""

    radius: Size
    length: Size


@dataclass(frozen=True)
class Capsule(_SizedShape):
    """A capsule along z: ``length`` (m) between the centres of its two half spheres."""

    radius: Size
    length: Size


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle surface: ``vertices`` (n, 3) in metres and ``triangles`` (m, 3), at least one.

    With a ``radius`` (m) it represents a finer surface within that distance
    (:func:`planner.robot.files.meshes.simplify`): a distance below the radius counts as a contact.
    """

    vertices: Floats
    triangles: Ints
    radius: float = 0.0

    def __post_init__(self) -> None:
        vertices = numbers("Mesh.vertices", self.vertices, ("n", 3), SceneError, FARTHEST)
        triangles = indices("Mesh.triangles", self.triangles, ("m", 3), len(vertices), SceneError)
        if not len(triangles):
            raise SceneError("Mesh.triangles must not be empty, got none: give at least one triangle.")
        object.__setattr__(self, "vertices", frozen(vertices))
        object.__setattr__(self, "triangles", frozen(triangles, np.int64))
        radius = float(numbers("Mesh.radius", self.radius, (), SceneError, FARTHEST))
        if not radius >= 0:
            raise SceneError(f"Mesh.radius must be at least 0 m, got {radius:g}: give it in metres.")
        object.__setattr__(self, "radius", radius)

    def content(self) -> list[Any]:
        """Return the values that a hash of the shape covers."""
        return [type(self).__name__, self.vertices, self.triangles, *([self.radius] if self.radius else [])]

    def merge_vertices(self) -> Mesh:
        """Return the same triangles with equal vertices merged, in the order of the triangles."""
        corners = self.vertices[self.triangles].reshape(-1, 3)
        first, which = distinct_rows(corners)
        order = np.argsort(first)
        rank = np.empty(len(order), dtype=np.int64)
        rank[order] = np.arange(len(order))
        return Mesh(corners[first[order]], rank[which].reshape(-1, 3), self.radius)


Shape: TypeAlias = Box | Sphere | Cylinder | Capsule | Mesh


def as_shape(what: str, given: Any) -> Shape:
    """Return a shape unchanged, or the mesh of a ``trimesh.Trimesh`` (m); TypeError otherwise."""
    if isinstance(given, Shape):
        return given
    if hasattr(given, "vertices") and hasattr(given, "faces"):
        return Mesh(given.vertices, given.faces).merge_vertices()
    kinds = "planner.Box, Sphere, Cylinder, Capsule, Mesh or a trimesh.Trimesh"
    raise TypeError(f"{what}: shape must be a {kinds}, got {type(given).__name__}.")


@dataclass(frozen=True, eq=False)
class Body:
    """A shape that a joint carries (``joint`` 0 is the base), placed in the joint's frame."""

    name: str
    link: str
    joint: int
    shape: Shape
    placement: Floats  # (4, 4), in the joint's frame
    color: tuple[float, float, float, float] = (0.7, 0.7, 0.7, 1.0)


class _PlacedShape:
    """A named shape with a rigid placement; ``object_id`` groups the shapes of one object."""

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
        """The name that contact permissions refer to."""
        return self.object_id or self.name


@dataclass(frozen=True, eq=False)
class Obstacle(_PlacedShape):
    """A shape (also a ``trimesh.Trimesh``) that stands at a placement (also a ``pinocchio.SE3``).

    With a ``speed_limit`` (m/s) it may move from time 0 on, no point faster than that: proofs of paths hold for its
    placement, and the proof of a trajectory gives the time until which any such motion is safe. ``frame`` is the frame
    of ``placement``, empty for the world; :func:`planner.robot.robot_in_scene.resolve_frames` resolves it.

    What a sensor saw while the robot stood in the state ``seen_at`` loses what is within ``self_filter`` (m) of the
    robot and what it carries, and its frame may be a link of the arm.
    """

    name: str
    shape: Shape
    placement: Floats  # (4, 4), in the world
    object_id: str | None = None
    speed_limit: float = 0.0  # m/s
    frame: str = ""
    seen_at: str = ""  # a named state, or q: and joint values
    self_filter: float = 0.02  # m


@dataclass(frozen=True, eq=False)
class Carried(_PlacedShape):
    """A shape that a link carries, placed (4, 4) in the link's frame or a ``frame`` moving with it.

    It may touch ``touch_links``. Its ``speed_limit`` (m/s) applies again after it is put down.
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
    """Return points (k, 3) and a radius r whose rounded convex hull contains the shape."""
    match shape:
        case Box(size):
            return CORNERS * np.asarray(size), 0.0
        case Sphere(radius):
            return np.zeros((1, 3)), radius
        case Capsule(radius, length):
            return np.array([[0, 0, -0.5 * length], [0, 0, 0.5 * length]]), radius
        case Cylinder(radius, length):
            # box around the discs: conservative by a factor of sqrt(2) at its four edges
            return CORNERS * np.array([2.0 * radius, 2.0 * radius, length]), 0.0
        case Mesh():
            return shape.vertices, shape.radius


def bounding_box(shape: Shape) -> tuple[Floats, Floats]:
    """Return the smallest and largest coordinates (3,) of a shape in its own frame."""
    points, radius = corners(shape)
    low, high = column_bounds(points)
    return low - radius, high + radius


def max_distance_from_origin(shape: Shape, placement: Floats) -> float:
    """Return an upper bound (m) on the distance of the placed shape's points from the origin."""
    if isinstance(shape, Cylinder):
        # the farthest point is on one of the two rims
        local = product(-placement[:3, 3], placement[:3, :3])  # the origin, seen from the cylinder
        across = float(np.hypot(local[0], local[1])) + shape.radius
        along = max(abs(end - local[2]) for end in (-0.5 * shape.length, 0.5 * shape.length))
        return float(np.hypot(across, along))
    points, radius = corners(shape)
    world = points @ placement[:3, :3].T + placement[:3, 3]
    return float(np.linalg.norm(world, axis=1).max() + radius)


def max_distance_from_axis(shape: Shape, placement: Floats, axis: Floats) -> float:
    """Return an upper bound (m) on the distance of the placed shape's points from an axis.

    The axis is the line through the origin along ``axis`` (3,).
    """
    points, radius = corners(shape)
    world = points @ placement[:3, :3].T + placement[:3, 3]
    across = world - np.outer(product(world, axis), axis)
    return min(float(np.linalg.norm(across, axis=1).max() + radius), max_distance_from_origin(shape, placement))
