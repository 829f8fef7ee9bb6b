"""Spheres and rounded boxes that contain a shape, for cheap conservative clearance bounds."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from planner.base.arrays import Floats, column_bounds, distinct_rows, frozen, length, product
from planner.robot.clouds import Points, Seen
from planner.robot.shapes import CORNERS, Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.robot.solids import solid_of, vertices_in_triangles


@dataclass(frozen=True, eq=False)
class Spheres:
    """``centres`` (k, 3) and ``radii`` (k,) in the shape's own frame, m."""

    centres: Floats
    radii: Floats


def sphere_cover(shape: Shape, count: int, enough: float = 0.0) -> Spheres:
    """Return up to about ``count`` spheres whose union contains the shape; more spheres fit more closely.

    Boxes and meshes are not divided into cells shorter than ``enough`` (m).
    """
    match shape:
        case Sphere(radius):
            return _spheres(np.zeros((1, 3)), radius)
        case Capsule(radius, length):
            return _along_capsule(radius, length, count)
        case Cylinder(radius, length):
            return _along_cylinder(radius, length, count)
        case Box(size):
            return _box_cells(np.array(size), count, enough)
        case Mesh():
            pieces = _split_long_triangles(shape, 1.5 * enough) if enough > 0 and not isinstance(shape, Seen) else shape
            cover = _cover_groups(pieces, split_pieces(pieces, count, enough))
            return _spheres(cover.centres, cover.radii + shape.radius)


def box_cover(mesh: Mesh, count: int) -> tuple[Floats, Floats]:
    """Return axis-aligned boxes around triangles or cells: centres (k, 3) and half sizes (k, 3), m."""
    groups, pieces = split_pieces(mesh, count), _pieces(mesh)
    low = np.array([pieces[g].reshape(-1, 3).min(axis=0) for g in groups])
    high = np.array([pieces[g].reshape(-1, 3).max(axis=0) for g in groups])
    return 0.5 * (low + high), 0.5 * (high - low)


def _pieces(mesh: Mesh) -> Floats:
    """Return the corners (m, k, 3) of the triangles; of what a sensor saw, of its cells, which are solid."""
    return mesh.cells if isinstance(mesh, Seen) else mesh.vertices[mesh.triangles]


def _spheres(centres: Any, radii: Any) -> Spheres:
    return Spheres(frozen(centres), frozen(np.broadcast_to(radii, (len(centres),))))


def _along_capsule(radius: float, length: float, count: int) -> Spheres:
    if length < 1e-9:
        return _spheres(np.zeros((1, 3)), radius)
    # spacing of 0.7 radii costs 6 % of the radius; more spheres than that buy little
    n = int(np.clip(np.ceil(length / (0.7 * radius)) + 1, 2, max(count, 2)))
    z = np.linspace(-0.5 * length, 0.5 * length, n)
    half_gap = 0.5 * length / (n - 1)
    return _spheres(np.column_stack([0 * z, 0 * z, z]), float(np.hypot(radius, half_gap)))


def _along_cylinder(radius: float, length: float, count: int) -> Spheres:
    n = int(np.clip(np.ceil(length / (0.7 * radius)), 1, max(count, 1)))
    z = (np.arange(n) + 0.5) * (length / n) - 0.5 * length
    return _spheres(np.column_stack([0 * z, 0 * z, z]), float(np.hypot(radius, 0.5 * length / n)))


def _box_cells(size: Floats, count: int, enough: float) -> Spheres:
    """Divide the box into near-cubes, always through the longest cell side, with a sphere around each."""
    cuts = np.ones(3, dtype=int)
    while (size / cuts).max() > enough:
        longest = int(np.argmax(size / cuts))
        if cuts.prod() // cuts[longest] * (cuts[longest] + 1) > count:
            break
        cuts[longest] += 1
    axes = [(np.arange(n) + 0.5) * (side / n) - 0.5 * side for n, side in zip(cuts, size, strict=True)]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return _spheres(centres, 0.5 * float(np.linalg.norm(size / cuts, axis=0)))


def _split_long_triangles(mesh: Mesh, longest: float, most: int = 20_000) -> Mesh:
    """Halve triangles until no side exceeds ``longest`` (m) or there are ``most`` of them.

    A sphere around a long triangle is mostly empty.
    """
    corners = mesh.vertices[mesh.triangles]
    while len(corners) < most:
        sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
        long = sides.max(axis=1) > longest
        if not long.any():
            break
        turn = sides[long].argmax(axis=1)
        a, b, c = (corners[long, (turn + k) % 3] for k in range(3))  # a-b is the longest side
        middle = 0.5 * (a + b)
        halves = [np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)]
        corners = np.concatenate([corners[~long], *halves])
    return Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


def split_pieces(mesh: Mesh, count: int, enough: float = 0.0) -> list[np.ndarray]:
    """Divide triangles or cells into ``count`` groups; the widest group is halved at its median each time."""
    middle = _pieces(mesh).mean(axis=1)
    groups = [np.arange(len(middle))]
    extents = [np.ptp(middle, axis=0)]
    while len(groups) < count:
        worst = int(np.argmax([extent.max() for extent in extents]))
        group, extent = groups[worst], extents[worst]
        if len(group) < 2 or extent.max() <= enough:
            break
        order = np.argsort(middle[group, int(np.argmax(extent))], kind="stable")
        halves = [group[order[: len(group) // 2]], group[order[len(group) // 2 :]]]
        groups[worst : worst + 1] = halves
        extents[worst : worst + 1] = [np.ptp(middle[half], axis=0) for half in halves]
    return groups


def _cover_groups(mesh: Mesh, groups: list[np.ndarray]) -> Spheres:
    # a sphere that holds the corners of a triangle or cell holds it: both are convex
    centres, radii, pieces = [], [], _pieces(mesh)
    for group in groups:
        points = pieces[group].reshape(-1, 3)
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        centres.append(centre)
        radii.append(np.linalg.norm(points - centre, axis=1).max())
    return _spheres(np.array(centres), np.array(radii))


_MANY = 200  # points: larger sets are reduced to the corners of their hull
_MOST = 4_000_000  # distances of corners from planes: larger meshes count as dented


@lru_cache(maxsize=1024)
def hull_of(mesh: Mesh) -> tuple[Floats, float]:
    """Return points (k, 3) that span a mesh's convex hull, and its :func:`dent_depth` (m).

    Of a cloud, the points are the corners of its box.
    """
    if isinstance(mesh, Seen):  # a box will do: no hull stands for a cloud
        low, high = column_bounds(mesh.vertices)
        return frozen(0.5 * (low + high) + CORNERS * (high - low)), np.inf
    return frozen(hull_corners(mesh.vertices[vertices_in_triangles(mesh)])), dent_depth(mesh)


def hull_corners(points: Floats) -> Floats:
    """Return the corners of the hull of ``points`` (n, 3); all distinct points if few or coplanar."""
    points = points[distinct_rows(points)[0]]
    if len(points) < _MANY:
        return points
    from scipy.spatial import ConvexHull, QhullError  # 0.3 s to load

    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        return points


def dent_depth(mesh: Mesh) -> float:
    """Return an estimate of the depth (m) of the surface below its convex hull; inf for open meshes.

    It is 0 for a convex mesh: the largest height of a corner above the plane of a triangle. For a simplified mesh,
    which is large, half of its smallest extent is an upper bound.
    """
    if mesh.radius:
        return 0.5 * float(np.ptp(mesh.vertices, axis=0).min())
    solid = solid_of(mesh)
    if solid is None or len(solid.corners) < len(mesh.triangles):
        return np.inf
    corners, points = solid.corners, mesh.vertices[mesh.triangles].reshape(-1, 3)
    points = points[distinct_rows(points)[0]]
    if len(corners) * len(points) > _MOST:
        return np.inf
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    offset = np.einsum("ij,ij->i", normal, corners[:, 0])
    outwards = np.where(product(normal, points.mean(axis=0)) > offset, -1.0, 1.0)
    above = (product(points, np.ascontiguousarray(normal.T)) - offset) * outwards
    return max(0.0, float(above.max()))


_THIN = 1e-7  # m: triangles thinner than this are widened
_WIDE = 1e-6  # m: by this


def widen_triangles(mesh: Mesh) -> Mesh:
    """Return the mesh with degenerate triangles widened by a micrometre, or the mesh itself.

    FCL reported contact for a ball of 2.3 m at 0.22 m from a mesh with two coinciding corners, coal at 0.56 m. The
    longest side stays; the opposite corner moves.
    """
    if isinstance(mesh, Points):
        return widen_points(mesh.vertices)
    corners = mesh.vertices[mesh.triangles]
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    thin = np.flatnonzero(area <= _THIN * sides.max(axis=1))
    if not len(thin):
        return mesh
    triangles, added = np.array(mesh.triangles), []
    for k in thin:
        longest = int(sides[k].argmax())
        a, b, c = (int(mesh.triangles[k, (longest + i) % 3]) for i in range(3))
        new = len(mesh.vertices) + len(added)
        along = mesh.vertices[b] - mesh.vertices[a]
        if not along.any():  # all three coincide
            added.append(mesh.vertices[a] + [_WIDE, 0.0, 0.0])
            b, along, new = new, np.array([1.0, 0.0, 0.0]), new + 1
        added.append(mesh.vertices[c] + _WIDE * _across(along))
        triangles[k] = a, b, new
    return Mesh(frozen(np.vstack([mesh.vertices, added])), triangles)


def widen_points(points: Floats) -> Mesh:
    """Return a triangle of a micrometre for each of the points (n, 3)."""
    vertices = (points[:, None] + _WIDE * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])).reshape(-1, 3)
    return Mesh(vertices, np.arange(len(vertices)).reshape(-1, 3))


def _across(along: Floats) -> Floats:
    """Return a unit vector (3,) perpendicular to a nonzero one."""
    axis = np.eye(3)[int(np.abs(along).argmin())]
    across: Floats = np.cross(along, axis).astype(float)
    return across / length(across)
