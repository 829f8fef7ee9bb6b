"""The door through which geometry read by coal enters: mesh files and URDF geometry as backend-neutral shapes."""

from __future__ import annotations

from pathlib import Path

import coal
import numpy as np

from planner.base.errors import FileError
from planner.world.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere


def read_mesh(path: Path, scale: float = 1.0) -> Mesh:
    """The triangles of an STL, OBJ, DAE or PLY file, in metres after ``scale``."""
    if not path.is_file():
        raise FileError(f"mesh file {path} not found: check 'file', which is relative to the scene file.")
    try:
        loaded = coal.MeshLoader().load(str(path), np.full(3, float(scale)))
    except (ValueError, RuntimeError) as error:
        raise FileError(f"mesh file {path} cannot be read ({error}): give an STL, OBJ, DAE or PLY file.") from None
    mesh = shape_of(loaded)
    if not isinstance(mesh, Mesh) or not len(mesh.triangles) or not np.isfinite(mesh.vertices).all():
        raise FileError(f"mesh file {path} holds no usable triangles: export it again.")
    return mesh


def shape_of(geometry: coal.CollisionGeometry) -> Shape:
    """A coal geometry as one of our shapes; ValueError names a kind that we do not have."""
    match geometry:
        case coal.Box():
            x, y, z = (float(2 * half) for half in geometry.halfSide)
            return Box((x, y, z))
        case coal.Sphere():
            return Sphere(float(geometry.radius))
        case coal.Capsule():
            return Capsule(float(geometry.radius), float(2 * geometry.halfLength))
        case coal.Cylinder():
            return Cylinder(float(geometry.radius), float(2 * geometry.halfLength))
        case coal.BVHModelBase():
            triangles = np.empty((geometry.num_tris, 3), dtype=np.int64)
            for row, triangle in zip(triangles, map(geometry.tri_indices, range(len(triangles))), strict=True):
                row[:] = triangle[0], triangle[1], triangle[2]  # not iterable: it has no end
            return Mesh(np.array(geometry.vertices()), triangles)
    raise ValueError(f"geometry of type {type(geometry).__name__} is not supported")
