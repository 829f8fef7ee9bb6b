"""Meshes of many triangles with fewer of them, rounded by so much that the whole surface lies within.

Vertices of one cell of a grid become one (Rossignac and Borrel 1993). If none moves further than r, no point of a
triangle does, so the old surface lies within r of the new one: what is proven of the new one with a rounding of r holds
for the old one. The way there stays within r of the new surface too, so that beyond that nothing changes between
inside and outside; and closed pieces stay closed, as every edge goes where its ends go.
"""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Ints
from planner.robot.shapes import Mesh
from planner.robot.solids import is_closed, pieces_of_vertices

MANY = 2000  # triangles: meshes of more are thinned
CELL = 1e-3  # m: a cell of the grid
_WIDEST = 1000.0  # m: cells of more have no number
_WORTH = 0.75  # share of the triangles above which the mesh stays as it is
_ROUNDING = 1e-9  # m by which a computed distance may be too short


def thinned(mesh: Mesh) -> Mesh:
    """The mesh itself where it has few triangles, or hardly fewer on a grid; else one whose rounding holds it."""
    if len(mesh.triangles) <= MANY or mesh.radius or float(np.ptp(mesh.vertices.T.copy(), axis=1).max()) > _WIDEST:
        return mesh
    found = _on_grid(mesh, None)
    if not is_closed(found.triangles):
        found = _on_grid(mesh, pieces_of_vertices(mesh))  # a closed piece is not to be joined to an open one
    return found if len(found.triangles) <= _WORTH * len(mesh.triangles) else mesh


def _on_grid(mesh: Mesh, apart: Ints | None) -> Mesh:
    """The mesh with the vertices of each cell as one; those with different numbers ``apart`` (n,) stay apart."""
    axes = np.ascontiguousarray(mesh.vertices.T)  # a tenth of the time along rows
    cells = ((axes - axes.min(axis=1, keepdims=True)) * (1 / CELL)).astype(np.int64)
    _, wide, high = cells.max(axis=1) + 1
    order, which = _ranked((cells[0] * wide + cells[1]) * high + cells[2])
    if apart is not None:
        order, which = _ranked(which * (len(apart) + 1) + apart)
    axes, ranks = axes[:, order], which[order]
    first = np.flatnonzero(np.diff(ranks, prepend=-1))
    middle = 0.5 * (np.minimum.reduceat(axes, first, axis=1) + np.maximum.reduceat(axes, first, axis=1))
    moved = axes - middle[:, ranks]
    radius = float(np.sqrt((moved * moved).sum(axis=0).max())) + _ROUNDING
    triangles = _remaining(which[mesh.triangles])
    used, triangles = np.unique(triangles, return_inverse=True)
    return Mesh(middle.T[used], triangles.reshape(-1, 3), radius)


def _ranked(keys: Ints) -> tuple[Ints, Ints]:
    """The order (n,) in which ``keys`` (n,) ascend, and the rank (n,) of each among the distinct ones."""
    order = np.argsort(keys, kind="stable")
    ranks = np.empty(len(keys), dtype=np.int64)
    ranks[order] = np.cumsum(np.diff(keys[order], prepend=keys[order[0]]) > 0)
    return order, ranks


def _remaining(triangles: Ints) -> Ints:
    """Triangles (m, 3) that have an area, and of the others the sides and corners that no other one has."""
    a, b, c = triangles.T
    has_area = (a != b) & (b != c) & (c != a)
    whole, flat = triangles[has_area], triangles[~has_area]
    count = int(triangles.max()) + 1
    sides = np.unique(flat.min(axis=1) * count + flat.max(axis=1))
    ends = np.concatenate([whole[:, [0, 1]], whole[:, [1, 2]], whole[:, [2, 0]]])
    sides = np.setdiff1d(sides, ends.min(axis=1) * count + ends.max(axis=1))
    low, high = np.divmod(sides, count)
    lines = np.column_stack([low, high, high])[low != high]
    points = np.setdiff1d(low[low == high], np.concatenate([whole.ravel(), lines.ravel()]))
    return np.concatenate([whole, lines, np.repeat(points[:, None], 3, axis=1)])
