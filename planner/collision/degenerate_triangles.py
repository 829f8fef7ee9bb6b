"""Triangles without area, which both collision libraries take for touching, or for nothing at all."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, frozen, length
from planner.robot.shapes import Mesh

_THIN = 1e-7  # m: triangles thinner than this are widened
_WIDE = 1e-6  # m: by this


def widened(mesh: Mesh) -> Mesh:
    """The mesh with a micrometre of width for triangles that have none; the same mesh where there are no such.

    FCL called a ball of 2.3 m touching that was 0.22 m away from a mesh with two coinciding corners, coal one that was
    0.56 m away. The longest side stays where it is; the corner opposite is replaced by one beside it.
    """
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


def _across(along: Floats) -> Floats:
    """A unit vector (3,) at right angles to one that is not zero."""
    axis = np.eye(3)[int(np.abs(along).argmin())]
    across: Floats = np.cross(along, axis).astype(float)
    return across / length(across)
