"""Worlds from sensors: points with a radius, and voxels.

    cloud = planner.Points(xyz, radius=0.01, noise=0.002)               # xyz (n, 3) m
    scene = planner.Scene("seen", [planner.Obstacle("table", cloud, np.eye(4))])

If every point of the true surface lies within the radius of a sample, then a motion that is free of the balls of that
radius is free of the surface.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from planner.base.arrays import Bools, Floats, Ints, column_bounds, frozen, numbers, plain_numbers
from planner.base.errors import Note, SceneError
from planner.base.yamlfile import FARTHEST
from planner.native.compiled import components, group_rows
from planner.problem.outcome import Record
from planner.robot.shapes import CORNERS, Mesh, Obstacle, Shape

_NEIGHBOURS, QUANTILE = 8, 0.99  # of a grid of points the 8th neighbour is twice the covering radius away
_TERMS = ("radius", "covering", "noise", "calibration", "is_estimated")  # of the radius of points
_LARGE = 50.0  # m: a cloud of more is likely in millimetres
_BLOCK = 0.5  # m: of a cloud that changes, what is proven again together
_MOST_SIDES = 32
_SECTION = 0.1  # m: of representatives that a test of enclosure can leave out together
_SAME_RADIUS = 1.25  # ratio up to which a block keeps a larger radius: estimates vary a little between images
_MOST_CELLS = 5e7  # of a grid: a byte each, and some numbers while cells merge
Region = tuple[float, float, float, float, float, float]


class Seen(Mesh):
    """A union of convex ``cells`` (m, k, 3), each the hull of k points, rounded by ``radius`` (m).

    The cells are solid, so nothing can be enclosed. Vertices and triangles are for display.
    """

    cells: Floats

    @cached_property
    def representatives(self) -> Floats:
        """A point (k, 3) of every connected component, or of more cells."""
        return frozen(self.cells[:, 0])

    def _set(self, **values: Any) -> None:
        """Set attributes: the numbers are checked, and a million of them take long to check again."""
        for name, value in values.items():
            object.__setattr__(self, name, frozen(value, value.dtype) if isinstance(value, np.ndarray) else value)


class Points(Seen):
    """A surface sampled at ``xyz`` (n, 3), m: all points within a radius of a sample are solid.

    The radius is a sum: ``radius`` (m) is the covering radius, the largest distance of a surface point from its nearest
    sample (default: :func:`estimate_covering_radius`, marked by ``is_estimated``); ``noise`` bounds the error of a
    sample, ``calibration`` that of the sensor's pose. A larger radius closes narrow passages; with one that is too
    small, proofs hold for the balls only.

    Samples that are not finite are counted in ``dropped`` and those that equal another in ``merged``; both are left
    out. Raises :class:`SceneError` without samples and for a radius of 0.
    """

    covering: float
    noise: float
    calibration: float
    is_estimated: bool
    dropped: int
    merged: int

    def __init__(
        self,
        xyz: Any,
        radius: float | None = None,
        noise: float = 0.0,
        calibration: float = 0.0,
        is_estimated: bool = False,
    ) -> None:
        given = plain_numbers("Points.xyz", xyz, SceneError)
        finite = given if np.isfinite(given).all() or given.ndim != 2 else given[np.isfinite(given).all(axis=1)]
        points = numbers("Points.xyz", finite, ("n", 3), SceneError, FARTHEST)
        if not len(points):
            raise SceneError("Points.xyz must hold a finite point, got none.")
        first = group_rows(np.ascontiguousarray(points), 0.0)[0]
        count, points = len(points), points if len(first) == len(points) else points[first]
        terms = {
            "radius": estimate_covering_radius(points) if radius is None else radius,
            "noise": noise,
            "calibration": calibration,
        }
        for name, term in terms.items():
            if not numbers(f"Points.{name}", term, (), SceneError, FARTHEST) >= 0:
                raise SceneError(f"Points.{name} must be at least 0 m, got {term:g}.")
        total = float(sum(terms.values()))
        if not total > 0:
            raise SceneError("Points.radius must be above 0 m, got 0: give the covering radius of the samples.")
        self._set(vertices=points, radius=total, covering=float(terms["radius"]), noise=float(noise))
        self._set(calibration=float(calibration), is_estimated=is_estimated or radius is None)
        self._set(dropped=len(given) - count, merged=count - len(points), cells=self.vertices[:, None])

    @cached_property
    def triangles(self) -> Ints:  # type: ignore[override]
        """A degenerate triangle (n, 3) for each sample."""
        return frozen(np.repeat(np.arange(len(self.vertices)), 3).reshape(-1, 3), np.int64)

    def content(self) -> list[Any]:
        return [type(self).__name__, self.vertices, self.radius]

    def part(self, chosen: Bools) -> Points:
        """Return the samples in the mask ``chosen`` (n,), at least one, with the same radius."""
        return self.with_samples(self.vertices[chosen])

    def with_samples(self, samples: Floats) -> Points:
        """Return other ``samples`` (n, 3), finite and distinct, with the same radius."""
        made = object.__new__(Points)
        same = {name: getattr(self, name) for name in _TERMS}
        made._set(vertices=samples, cells=samples[:, None], dropped=0, merged=0, **same)
        return made

    def __repr__(self) -> str:
        return f"<Points: {len(self.vertices)} within {1e3 * self.radius:.3g} mm of a surface>"

    @cached_property
    def representatives(self) -> Floats:
        """A point (k, 3) of every connected component of the balls, or of more; neighbours in sequence."""
        points = self.vertices[components(self.vertices, self.radius)]
        return frozen(points[np.argsort(group_rows(points, _SECTION)[1], kind="stable")])


class Voxels(Seen):
    """Solid cells of a grid: ``occupied`` (nx, ny, nz), cubes of ``pitch`` (m) from ``origin`` (3,).

    Neighbouring cubes are merged into cuboids. A cube exceeds its content by up to its diagonal.
    """

    occupied: Bools
    pitch: float
    origin: Floats

    def __init__(self, occupied: Any, pitch: float, origin: Any = (0.0, 0.0, 0.0)) -> None:
        solid = np.asarray(occupied, dtype=bool)
        if solid.ndim != 3 or not solid.any():
            raise SceneError(f"Voxels.occupied must be an array (nx, ny, nz) with a solid cell, got {solid.shape}.")
        require_few_cells("Voxels.occupied", solid.shape)
        if not numbers("Voxels.pitch", pitch, (), SceneError, FARTHEST) > 0:
            raise SceneError(f"Voxels.pitch must be above 0 m, got {pitch:g}.")
        corner = numbers("Voxels.origin", origin, (3,), SceneError, FARTHEST)
        cuboids = merge_cells(solid)
        low, high = corner + pitch * cuboids[:, :3], corner + pitch * cuboids[:, 3:]
        cells = 0.5 * (low + high)[:, None] + CORNERS * (high - low)[:, None]
        triangles = (8 * np.arange(len(cells))[:, None, None] + _FACES).reshape(-1, 3)
        self._set(vertices=cells.reshape(-1, 3), triangles=triangles, radius=0.0, cells=cells)
        self._set(occupied=solid, pitch=float(pitch), origin=corner)

    def __repr__(self) -> str:
        return f"<Voxels: {int(self.occupied.sum())} cubes of {1e3 * self.pitch:.3g} mm>"


def require_few_cells(what: str, shape: Any) -> None:
    """Raise :class:`SceneError` for a grid of more cells than fit into memory."""
    if (cells := float(np.prod(np.asarray(shape, dtype=float)))) > _MOST_CELLS:
        size = " x ".join(str(int(count)) for count in shape)
        raise SceneError(
            f"{what} must give at most {_MOST_CELLS:.0f} cells, got {size} = {cells:.2g}: "
            "give larger cells, or a smaller space."
        )


# (12, 3) of the corners of a cube, seen from outside; a corner's number has the bits y, x, z
_FACES = np.array([*map(int, "310230764574540150732672620460751371")]).reshape(12, 3)


def merge_cells(occupied: Bools) -> Ints:
    """Return disjoint cuboids (k, 6) of cells, low then high corner, with the same union.

    Runs along z are merged to rectangles along y, and these to cuboids along x, if their ends agree.
    """
    flat = np.pad(occupied, ((0, 0), (0, 0), (1, 1))).astype(np.int8)
    change = np.diff(flat, axis=2)
    x, y, low = np.nonzero(change == 1)
    high = np.nonzero(change == -1)[2]
    rows = np.column_stack([x, y, low, x + 1, y + 1, high])
    for axis in (1, 0) if len(rows) else ():
        others = [k for k in range(6) if k % 3 != axis]
        rows = rows[np.lexsort([rows[:, axis], *(rows[:, k] for k in others)])]
        same = (rows[1:, others] == rows[:-1, others]).all(axis=1) & (rows[1:, axis] == rows[:-1, axis + 3])
        first = np.flatnonzero(np.append(True, ~same))
        last = np.append(first[1:], len(rows)) - 1
        merged = rows[first]
        merged[:, axis + 3] = rows[last, axis + 3]
        rows = merged
    return rows


def split_regions(name: str, cloud: Points, placement: Floats, regions: Mapping[str, Region]) -> list[Obstacle]:
    """Return the cloud as obstacles: one per region (x0, y0, z0, x1, y1, z1) m, and the rest.

    Regions are in the cloud's frame. Contact permissions can then name an object in the cloud.
    """
    rest, made = np.ones(len(cloud.vertices), dtype=bool), []
    for part, bounds in regions.items():
        low, high = np.reshape(bounds, (2, 3))
        inside = rest & ((cloud.vertices >= low) & (cloud.vertices <= high)).all(axis=1)
        if not inside.any():
            raise SceneError(f"'{name}': region '{part}' must hold a point, got none: check its bounds.")
        made.append(Obstacle(part, cloud.part(inside), placement))
        rest &= ~inside
    return [*([Obstacle(name, cloud.part(rest), placement)] if rest.any() else []), *made]


def split_blocks(item: Obstacle, known: Iterable[Obstacle] = ()) -> list[Obstacle]:
    """Return points or voxels as obstacles of one object, one per cube of a grid; reuse ``known`` blocks."""
    seen = item.shape
    if not isinstance(seen, Points | Voxels):
        return [item]
    same = {block.name: block for block in known if np.array_equal(block.placement, item.placement)}
    made: list[Obstacle] = []
    for cell, part in _blocks_of(seen):
        name = f"{item.name}[{', '.join(map(str, cell))}]"
        old = same.get(name)
        if old is None or not _stands_for(old.shape, seen, part):
            shape = seen.with_samples(part) if isinstance(seen, Points) else Voxels(part[0], seen.pitch, part[1])
            old = Obstacle(name, shape, item.placement, object_id=item.object)
        made.append(old)
    return made


def _blocks_of(seen: Points | Voxels) -> Iterable[tuple[list[int], Any]]:
    """Return the numbers of blocks, and what each holds."""
    if isinstance(seen, Voxels):
        return _blocks_of_voxels(seen)
    return zip(*group_samples(seen, _BLOCK), strict=True)


def group_samples(cloud: Points, side: float) -> tuple[list[list[int]], list[Floats]]:
    """Return the cells of a grid of ``side`` (m) that hold a sample, and the samples in each.

    In a cloud of more than 32 sides, as of one in millimetres, cells are larger by a power of two.
    """
    low, high = column_bounds(cloud.vertices)
    side *= 2.0 ** np.ceil(np.log2(max(1.0, float((high - low).max()) / (_MOST_SIDES * side))))
    first, which, _ = group_rows(cloud.vertices, side)
    small = which.astype(np.uint16) if len(first) < 2**16 else which  # NumPy sorts 16 bits by their digits
    order = np.argsort(small, kind="stable")
    cells = np.floor(cloud.vertices[first] / side).astype(np.int64).tolist()
    return cells, np.split(cloud.vertices[order], np.cumsum(np.bincount(which))[:-1])


def _blocks_of_voxels(voxels: Voxels) -> Iterator[tuple[list[int], tuple[Bools, Floats]]]:
    """Yield blocks of a grid with a solid cell: their numbers, cells and origins."""
    size = max(1, round(_BLOCK / voxels.pitch), max(voxels.occupied.shape) // _MOST_SIDES)
    blocks = [range(0, count, size) for count in voxels.occupied.shape]
    for low in itertools.product(*blocks):
        part = voxels.occupied[tuple(slice(k, k + size) for k in low)]
        if part.any():
            yield [k // size for k in low], (part, voxels.origin + voxels.pitch * np.array(low))


def _stands_for(old: Shape, seen: Points | Voxels, part: Any) -> bool:
    """Whether a block ``old`` can stand for a ``part`` of what is seen now: equal, and no smaller."""
    if isinstance(seen, Points) and isinstance(old, Points):
        terms = all(getattr(old, name) == getattr(seen, name) for name in _TERMS[2:])
        return terms and seen.radius <= old.radius <= _SAME_RADIUS * seen.radius and np.array_equal(old.vertices, part)
    if isinstance(seen, Voxels) and isinstance(old, Voxels):
        return old.pitch == seen.pitch and np.array_equal(old.occupied, part[0]) and np.array_equal(old.origin, part[1])
    return False


def _tree_of(points: Floats) -> KDTree:
    return KDTree(points, compact_nodes=False, balanced_tree=False)  # a balanced one takes three times as long


def estimate_covering_radius(points: Floats) -> float:
    """Return an estimate (m) of the largest distance of a surface point from the samples (n, 3).

    It is the distance from a sample to its 8th neighbour, at the 99 % quantile: twice the covering radius of a square
    grid, and about 1.3 times that of random samples. It misses holes much larger than the spacing. Raises
    :class:`SceneError` for fewer than nine samples.
    """
    if len(points) <= _NEIGHBOURS:
        raise SceneError(f"Points.radius must be given for {len(points)} points: an estimate needs at least 9.")
    some = points[:: max(1, len(points) // 20_000)]
    distance = _tree_of(points).query(some, k=_NEIGHBOURS + 1)[0][:, -1]
    return float(np.quantile(distance, QUANTILE))


@dataclass(frozen=True, kw_only=True)
class CloudRecord(Record):
    """The points of an obstacle and the terms of its radius, m."""

    obstacle: str
    points: int
    radius: float
    """the sum of the three terms"""
    covering: float
    """covering radius of the samples"""
    estimated: bool
    """whether the covering radius is an estimate"""
    noise: float
    calibration: float
    dropped: int
    """samples that were not finite"""
    merged: int
    """samples that equal another"""

    @property
    def text(self) -> str:
        """The record as a sentence without its full stop."""
        terms = {"covering radius": self.covering, "noise": self.noise, "calibration": self.calibration}
        words = [f"{term} {1e3 * value:.4g} mm" for term, value in terms.items()]
        words[0] += " (estimated)" if self.estimated else ""
        text = f"'{self.obstacle}' is solid within {1e3 * self.radius:.4g} mm of {self.points} points: "
        left_out = {"were not finite": self.dropped, "equal another": self.merged}
        reasons = [f"; {count} samples {why} and are left out" for why, count in left_out.items() if count]
        return text + ", ".join(words) + "".join(reasons)


def record_clouds(obstacles: Iterable[Obstacle]) -> list[CloudRecord]:
    """Return a record of each cloud among ``obstacles``; the blocks of one object count together."""
    clouds: dict[str, list[Points]] = {}
    for item in obstacles:
        if isinstance(item.shape, Points):
            clouds.setdefault(item.object, []).append(item.shape)
    return [
        CloudRecord(
            obstacle=name,
            points=sum(len(part.vertices) for part in parts),
            radius=parts[0].radius,
            covering=parts[0].covering,
            estimated=parts[0].is_estimated,
            noise=parts[0].noise,
            calibration=parts[0].calibration,
            dropped=sum(part.dropped for part in parts),
            merged=sum(part.merged for part in parts),
        )
        for name, parts in clouds.items()
    ]


def notes_on_clouds(obstacles: Iterable[Obstacle]) -> tuple[Note, ...]:
    """Return a note on each cloud; grave where its radius is an estimate or its size is unlikely."""
    items = list(obstacles)
    bounds: dict[str, list[tuple[Floats, Floats]]] = {}
    for item in items:
        if isinstance(item.shape, Points):
            bounds.setdefault(item.object, []).append(column_bounds(item.shape.vertices))
    large = {name for name, each in bounds.items() if np.ptp(np.reshape(each, (-1, 3)), axis=0).max() > _LARGE}
    hint = f". It is larger than {_LARGE:g} m: if its file is in millimetres, give scale: 0.001."
    return tuple(
        Note(each.text + hint) if each.obstacle in large else Note(f"{each.text}.", grave=each.estimated)
        for each in record_clouds(items)
    )
