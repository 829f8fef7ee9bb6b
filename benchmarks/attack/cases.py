"""Pairs of shapes near each other: random and awkward ones, and small changes of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.robot.clouds import Points, Voxels
from planner.robot.depth_image import DepthImage
from planner.robot.poses import pose
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere, corners

KINDS = ("box", "sphere", "cylinder", "capsule", "mesh")
SEEN = ("points", "voxels", "depth")  # obstacles only

_SIZES = (-3.0, 0.5)  # decimal exponents of lengths (m)
_GAPS = (-7.0, 0.0)  # of what is left between two points of the shapes
_FAR = (0.0, 3.0)  # of how far both are from the origin, where they are far


@dataclass(frozen=True, eq=False)
class Case:
    """Two shapes and their placements (4, 4) in the world; ``linked``: both are carried by joints of the robot.

    ``aim``: the call that is to claim too much.
    """

    first: Shape
    second: Shape
    place_first: Floats
    place_second: Floats
    linked: bool
    aim: str

    def describe(self) -> dict[str, Any]:
        """Enough to make the case again."""
        return {
            "shapes": [spell(self.first), spell(self.second)],
            "placements": [self.place_first.tolist(), self.place_second.tolist()],
            "linked": self.linked,
        }


def spell(shape: Shape) -> str:
    """A shape with all its digits."""
    if isinstance(shape, Points):
        return f"Points(np.array({shape.vertices.tolist()}), {shape.radius!r})"
    if isinstance(shape, Voxels):
        return f"Voxels(np.array({shape.occupied.astype(int).tolist()}), {shape.pitch!r}, {shape.origin.tolist()})"
    if isinstance(shape, Mesh):
        return f"Mesh(np.array({shape.vertices.tolist()}), np.array({shape.triangles.tolist()}))"
    return repr(shape)


def random_case(kinds: tuple[str, str], aim: str, rng: np.random.Generator) -> Case:
    """Shapes of two ``kinds`` in either order, some far from the origin, some with parallel axes."""
    a, b = (random_shape(kind, rng) for kind in (kinds if kinds[1] in SEEN else rng.permutation(kinds)))
    place = _placement(random_turn(rng), rng.normal(size=3))
    turn = place[:3, :3] if rng.random() < 0.2 else random_turn(rng)
    linked = bool(rng.random() < 0.3) and kinds[1] not in SEEN
    case = Case(a, b, place, place_near(a, place, b, turn, rng), linked, aim)
    if rng.random() < 0.1:
        shift = 10.0 ** rng.uniform(*_FAR) * rng.normal(size=3)
        places = (_placement(p[:3, :3], p[:3, 3] + shift) for p in (case.place_first, case.place_second))
        case = replace(case, **dict(zip(("place_first", "place_second"), places, strict=True)))
    return case


def change_case(case: Case, size: float, rng: np.random.Generator) -> Case:
    """Return the case with one change: of a shape, a turn, a shift, or the distance of the two."""
    place = case.place_second
    match rng.integers(5):
        case 0:
            return replace(case, first=change_shape(case.first, size, rng))
        case 1:
            return replace(case, second=change_shape(case.second, size, rng))
        case 2:
            turn = small_turn(size, rng) @ place[:3, :3] if rng.random() < 0.7 else case.place_first[:3, :3]
            return replace(case, place_second=_placement(turn, place[:3, 3]))
        case 3:
            return replace(case, place_second=_placement(place[:3, :3], place[:3, 3] + size * rng.normal(size=3)))
    return replace(case, place_second=place_near(case.first, case.place_first, case.second, place[:3, :3], rng))


def place_near(first: Shape, place: Floats, second: Shape, turn: Floats, rng: np.random.Generator) -> Floats:
    """A placement (4, 4) of the second, turned (3, 3) so, near the first.

    In most cases on the far side of a plane that touches the first, a gap away from it; the plane lies along a face or
    an axis of one of the two, or anyhow. Else with any point of its surface near any point of the first's.
    """
    gap = 10.0 ** rng.uniform(*_GAPS)
    away = [rng.normal(size=3), *place[:3, :3].T, *turn.T][int(rng.integers(7))]
    away = away * rng.choice([-1.0, 1.0]) / np.linalg.norm(away)
    if rng.random() < 0.3:
        at, to = place[:3, :3] @ point_on(first, rng) + place[:3, 3], turn @ point_on(second, rng)
        return _placement(turn, at + gap * away - to)
    at = _farthest(first, place[:3, :3], away) + place[:3, 3]
    to = _farthest(second, turn, -away)
    shift = 10.0 ** rng.uniform(*_SIZES) * rng.normal(size=3) * (rng.random() < 0.7)
    return _placement(turn, at + gap * away - to + shift - (shift @ away) * away)


def _farthest(shape: Shape, turn: Floats, direction: Floats) -> Floats:
    """The point (3,) of a turned shape farthest along a unit vector."""
    local = direction @ turn
    if isinstance(shape, Cylinder):
        across = local[:2] / max(float(np.hypot(*local[:2])), 1e-300)
        return turn @ np.array([*(shape.radius * across), np.copysign(0.5 * shape.length, local[2])])
    points, radius = corners(shape)
    return turn @ points[(points @ local).argmax()] + radius * direction


def random_turn(rng: np.random.Generator) -> Floats:
    """A rotation (3, 3); by right angles about the axes in one case of three."""
    if rng.random() < 0.33:
        return pose([0, 0, 0], rpy=(0.5 * np.pi * rng.integers(0, 4, size=3)).tolist())[:3, :3]
    return pose([0, 0, 0], quaternion=rng.normal(size=4).tolist())[:3, :3]


def small_turn(size: float, rng: np.random.Generator) -> Floats:
    """A rotation (3, 3) by about ``size`` rad."""
    return pose([0, 0, 0], rpy=(size * rng.normal(size=3)).tolist())[:3, :3]


def _placement(turn: Floats, position: Floats) -> Floats:
    placement = np.eye(4)
    placement[:3, :3], placement[:3, 3] = turn, position
    return placement


def random_shape(kind: str, rng: np.random.Generator) -> Shape:
    """Lengths from a millimetre to three metres, each drawn alone: rods, needles and sheets are common."""
    a, b, c = (10.0 ** rng.uniform(*_SIZES, size=3)).tolist()
    match kind:
        case "box":
            return Box((a, b, c))
        case "sphere":
            return Sphere(a)
        case "cylinder":
            return Cylinder(a, b)
        case "capsule":
            return Capsule(a, b)
        case "points":
            return _random_points(a, b, 10.0 ** rng.uniform(-4.0, -0.5), rng)
        case "voxels":
            occupied = rng.random(rng.integers(1, 5, size=3)) < rng.uniform(0.1, 1.0)
            occupied.flat[0] = True
            return Voxels(occupied, 0.3 * a, b * rng.normal(size=3))
        case "depth":
            return _random_view(rng)
    return _random_mesh(a, b, c, rng)


def _random_points(a: float, b: float, radius: float, rng: np.random.Generator) -> Points:
    """A single point, a needle, a patch, a heap of blobs, or two points many times, some an ulp apart."""
    count = int(rng.integers(2, 60))
    match rng.integers(5):
        case 0:
            xyz = a * rng.normal(size=(1, 3))
        case 1:
            xyz = np.linspace(-a, a, count)[:, None] * rng.normal(size=3)
        case 2:
            xyz = rng.uniform(-1.0, 1.0, (count, 3)) * (a, b, 0.0)
        case 3:
            xyz = a * rng.normal(size=(3, 3))[rng.integers(3, size=count)] + 0.1 * b * rng.normal(size=(count, 3))
        case _:
            xyz = np.nextafter(
                a * rng.normal(size=(2, 3))[rng.integers(2, size=count)], rng.choice([-10.0, 10.0], size=(count, 1))
            )
    return Points(xyz, radius)


def _random_view(rng: np.random.Generator) -> Points | Voxels:
    """The surface or the unknown space of a small depth image with steps, holes and pixels that met nothing."""
    depth = rng.choice([0.0, 0.4, 0.5, 0.9, 5.0], (2, 3)).repeat(4, axis=0).repeat(4, axis=1)
    depth += 0.01 * rng.random(depth.shape)
    image = DepthImage(depth, (10, 10, 6, 4), np.eye(4), (0.1, 1.2), pitch=float(rng.uniform(0.1, 0.3)))
    surface, unknown = image.surface(), image.unknown_space()
    return surface if surface and (unknown is None or rng.random() < 0.5) else unknown or Points(np.zeros((1, 3)), 0.1)


def _random_mesh(a: float, b: float, c: float, rng: np.random.Generator) -> Mesh:
    """A plate of two triangles, loose triangles (one may be degenerate), a closed box, or a bent strip."""
    match rng.integers(4):
        case 0:
            corners = np.array([[-a, -b, 0.0], [a, -b, 0.0], [a, b, 0.0], [-a, b, 0.0]])
            return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))
        case 1:
            count = int(rng.integers(1, 5))
            sizes = np.array([a, b, c]) * 10.0 ** rng.uniform(-1.0, 0.0, size=(count, 1, 3))
            corners = sizes * rng.normal(size=(count, 3, 3)) + max(a, b, c) * rng.normal(size=(count, 1, 3))
            if rng.random() < 0.3:
                corners[0, 2] = corners[0, 0] + rng.uniform(0.0, 1.0) * (corners[0, 1] - corners[0, 0])
            return Mesh(corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))
        case 2:
            corners = np.array([[x, y, z] for x in (-a, a) for y in (-b, b) for z in (-c, c)])
            faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
            return Mesh(corners, np.array([t for f in faces for t in ([f[0], f[1], f[2]], [f[0], f[2], f[3]])]))
    steps = np.arange(6)
    rim = np.column_stack([a * steps, np.zeros(6), c * rng.normal(size=6)])
    corners = np.concatenate([rim, rim + np.array([0.0, b, 0.0])], dtype=np.float64)
    return Mesh(corners, np.array([t for k in range(5) for t in ([k, k + 1, k + 6], [k + 1, k + 7, k + 6])]))


def change_shape(shape: Shape, size: float, rng: np.random.Generator) -> Shape:
    """Other lengths; of a mesh other corners, now and then rounded so that sides come to lie parallel."""
    grown = np.exp(size * rng.normal(size=3) * (rng.random(3) < 0.6)).tolist()
    match shape:
        case Box((a, b, c)):
            return Box((a * grown[0], b * grown[1], c * grown[2]))
        case Sphere(radius):
            return Sphere(radius * grown[0])
        case Cylinder(radius, length):
            return Cylinder(radius * grown[0], length * grown[1])
        case Capsule(radius, length):
            return Capsule(radius * grown[0], length * grown[1])
        case Points(vertices=vertices):
            some = rng.random((len(vertices), 1)) < rng.random()
            moved = vertices + size * (np.ptp(vertices) + shape.radius) * rng.normal(size=vertices.shape) * some
            return Points(moved, shape.radius * grown[0])
        case Voxels(occupied=occupied):
            flipped = occupied ^ (rng.random(occupied.shape) < 0.2 * size)
            return Voxels(flipped if flipped.any() else occupied, shape.pitch * grown[0], shape.origin)
        case Mesh(vertices, triangles):
            if rng.random() < 0.15:
                return Mesh(np.round(vertices, int(rng.integers(1, 4))), triangles)
            moved = vertices + size * np.ptp(vertices) * rng.normal(size=vertices.shape) * (
                rng.random(vertices.shape) < 0.2
            )
            return Mesh(moved * grown, triangles)


def point_on(shape: Shape, rng: np.random.Generator) -> Floats:
    """A point (3,) on the surface, corners and edges among them, in the shape's own frame."""
    away = rng.normal(size=3)
    away /= np.linalg.norm(away)
    match shape:
        case Box(size):
            return 0.5 * np.array(size) * np.clip(2.0 * away, -1.0, 1.0)
        case Sphere(radius):
            return radius * away
        case Cylinder(radius, length):
            across = np.append(away[:2] / np.linalg.norm(away[:2]), 0.0)
            return radius * min(1.0, 2.0 * rng.random()) * across + np.array(
                [0.0, 0.0, 0.5 * length * np.clip(2.0 * away[2], -1, 1)]
            )
        case Capsule(radius, length):
            return radius * away + np.array([0.0, 0.0, 0.5 * length * np.clip(2.0 * away[2], -1, 1)])
        case Mesh(vertices, triangles):
            share = rng.dirichlet([0.5, 0.5, 0.5])
            return share @ vertices[triangles[rng.integers(len(triangles))]]
