"""Grasps from an object's shape, where nobody gives any: the tool's z along the approach, its y where fingers close."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from planner.base.arrays import Floats
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.tasks.file import Grasp, TaskError, tool_at, turned_about

MOST = 200  # grasps of an object
_SPARE = 2e-3  # m: so much wider than the object the gripper has to open
_DEPTH, _ROUND = 0.02, 2.0  # m below the surface that the tool's origin comes to lie at most; times that in round sides
_ALONG = (0.0, 0.25, -0.25)  # of the object's length, beside its middle
_TILTS = (0.0, 0.35, -0.35)  # rad about the axis along which the fingers close
_ABOUT = 16  # directions around an axis
_SPHERE, _TURNS = 24, 8  # directions towards a sphere, turns about each


def generated(name: str, shape: Shape, opening: float | None) -> tuple[Grasp, ...]:
    """At most ``MOST`` grasps of a shape by a tool that opens ``opening`` (m) at most, None for one that only touches.

    The same ones each time: boxes are taken between two opposite faces, cylinders and capsules across their axis and
    from their ends, spheres from all around. Raises :class:`TaskError` where the gripper does not open that wide, and
    for meshes.
    """
    if isinstance(shape, Mesh):
        raise TaskError(f"'{name}' is a mesh, of which no grasps are generated: give its 'grasps'.")
    widest = np.inf if opening is None else opening - _SPARE
    depth = 0.0 if opening is None else _DEPTH
    found = list(_of(shape, widest, depth))
    if not found:
        raise TaskError(
            f"'{name}' is wider than the gripper opens ({opening:g} m) wherever it could be grasped: give its 'grasps'."
        )
    chosen = np.unique(np.linspace(0, len(found) - 1, min(MOST, len(found))).round().astype(int))
    return tuple(found[k] for k in chosen)


def _of(shape: Shape, widest: float, deep: float) -> Iterator[Grasp]:
    match shape:
        case Box(size):
            yield from _box(size, widest, deep)
        case Sphere(radius):
            if 2 * radius <= widest:
                depth = min(radius, _ROUND * deep)
                for out in _directions():
                    yield from turned_about((radius - depth) * out, -out, 2 * radius, _TURNS)
        case Cylinder(radius, length) | Capsule(radius, length):
            if 2 * radius <= widest:
                yield from _sides(radius, length, _ROUND * deep)
                top = 0.5 * length + (radius if isinstance(shape, Capsule) else 0.0)
                for sign in (1.0, -1.0):
                    out = np.array([0.0, 0.0, sign])
                    yield from turned_about((top - min(deep, top)) * out, -out, 2 * radius, _ABOUT)
        case _:
            return


def _box(size: Sequence[float], widest: float, deep: float) -> Iterator[Grasp]:
    axes = np.eye(3)
    for face in range(3):
        inside = 0.5 * size[face] - min(deep, 0.5 * size[face])
        for side in (1.0, -1.0):
            for closing in (k for k in range(3) if k != face and size[k] <= widest):
                across = 3 - face - closing
                for share in _ALONG:
                    at = side * inside * axes[face] + share * size[across] * axes[across]
                    yield from _tilted(at, -side * axes[face], axes[closing], size[closing])


def _sides(radius: float, length: float, deep: float) -> Iterator[Grasp]:
    for angle in np.arange(_ABOUT) * 2 * np.pi / _ABOUT:
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        for share in _ALONG:
            at = (radius - min(radius, deep)) * out + np.array([0.0, 0.0, share * length])
            yield from _tilted(at, -out, np.array([-out[1], out[0], 0.0]), 2 * radius)


def _tilted(at: Floats, approach: Floats, closing: Floats, width: float) -> Iterator[Grasp]:
    """The grasp and those tilted about the axis along which the fingers close, each with either finger first."""
    for tilt in _TILTS:
        tilted = np.cos(tilt) * approach + np.sin(tilt) * np.cross(closing, approach)
        for sign in (1.0, -1.0):
            yield Grasp(tool_at(at, tilted, sign * closing), width)


def _directions() -> Floats:
    """Unit vectors (k, 3) evenly around, on a spiral (Fibonacci's lattice)."""
    k = np.arange(_SPHERE) + 0.5
    height, angle = 1 - 2 * k / _SPHERE, np.pi * (1 + np.sqrt(5)) * k
    across = np.sqrt(1 - height**2)
    return np.column_stack([across * np.cos(angle), across * np.sin(angle), height])
